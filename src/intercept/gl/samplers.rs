//! The samplers of a program, and textures that stop being what they were.

use super::context::Context;
use super::hook::hooks;
use crate::backend::gl::api::{self, Gl};
use std::ffi::{CStr, c_char, c_void};

/// Locations of a linked program's samplers of two-dimensional textures.
pub fn locations(gl: &Gl, program: u32) -> Vec<i32> {
    let mut count = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_programiv(program, api::GL_ACTIVE_UNIFORMS, &mut count) };
    let mut found = Vec::new();
    for index in 0..u32::try_from(count).unwrap_or(0) {
        let mut text: [c_char; 256] = [0; 256];
        let (mut length, mut size, mut kind) = (0, 0, 0);
        // SAFETY: writes at most 256 characters with their NUL, which is what the location is asked by.
        let location = unsafe {
            gl.get_active_uniform(program, index, 256, &mut length, &mut size, &mut kind, text.as_mut_ptr());
            gl.get_uniform_location(program, CStr::from_ptr(text.as_ptr()).as_ptr())
        };
        let samples = matches!(kind, api::GL_SAMPLER_2D | api::GL_INT_SAMPLER_2D | api::GL_UNSIGNED_INT_SAMPLER_2D);
        if samples && location >= 0 {
            // The elements of an array have locations that follow each other.
            found.extend(location..location + size.max(1));
        }
    }
    found
}

/// The texture that is bound at `target` gets another size or format.
fn respecified(ctx: &mut Context, target: u32) {
    if target == api::GL_TEXTURE_2D && ctx.duplicates.any() {
        let mut texture = 0;
        // SAFETY: writes one integer.
        unsafe { ctx.gl.get_integerv(api::GL_TEXTURE_BINDING_2D, &mut texture) };
        super::duplicate::forget_texture(ctx, texture as u32);
    }
}

hooks! {
    "glTexImage2D" tex_image2_d(target: u32, level: i32, internal: i32, w: i32, h: i32, border: i32, format: u32, kind: u32, pixels: *const c_void) = |ctx, gl| {
        if level == 0 && !ctx.compiling() { respecified(ctx, target) }
        gl.tex_image2_d(target, level, internal, w, h, border, format, kind, pixels);
    };
    "glTexStorage2D" tex_storage2_d(target: u32, levels: i32, internal: u32, w: i32, h: i32) = |ctx, gl| {
        respecified(ctx, target);
        gl.tex_storage2_d(target, levels, internal, w, h);
    };
    "glGenerateMipmap" generate_mipmap(target: u32) = |ctx, gl| {
        if target == api::GL_TEXTURE_2D && ctx.duplicates.any() {
            super::duplicate::refuse_texture(ctx, 0, "it makes smaller pictures of it");
        }
        gl.generate_mipmap(target);
    };
    "glGetTexImage" get_tex_image(target: u32, level: i32, format: u32, kind: u32, pixels: *mut c_void) = |ctx, gl| {
        if target == api::GL_TEXTURE_2D && ctx.duplicates.any() {
            super::duplicate::refuse_texture(ctx, 0, "it reads it back");
        }
        gl.get_tex_image(target, level, format, kind, pixels);
    };
    "glDeleteTextures" delete_textures(count: i32, names: *const u32) = |ctx, gl| {
        if ctx.duplicates.any() && !names.is_null() {
            for name in std::slice::from_raw_parts(names, usize::try_from(count).unwrap_or(0)) {
                super::duplicate::forget_texture(ctx, *name);
            }
        }
        gl.delete_textures(count, names);
    };
}
