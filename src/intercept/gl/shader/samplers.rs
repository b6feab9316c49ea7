//! Samplers of a program.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::shader::programs::Sampler;
use std::ffi::{CStr, c_char};

/// Returns the texture target that a uniform of this type samples, if programs can draw to such
/// textures.
pub(in crate::intercept::gl) fn target_of(kind: u32) -> Option<u32> {
    match kind {
        api::GL_SAMPLER_2D | api::GL_SAMPLER_2D_SHADOW | api::GL_INT_SAMPLER_2D | api::GL_UNSIGNED_INT_SAMPLER_2D => {
            Some(api::GL_TEXTURE_2D)
        }
        api::GL_SAMPLER_2D_RECT
        | api::GL_SAMPLER_2D_RECT_SHADOW
        | api::GL_INT_SAMPLER_2D_RECT
        | api::GL_UNSIGNED_INT_SAMPLER_2D_RECT => Some(api::GL_TEXTURE_RECTANGLE),
        api::GL_SAMPLER_2D_MULTISAMPLE
        | api::GL_INT_SAMPLER_2D_MULTISAMPLE
        | api::GL_UNSIGNED_INT_SAMPLER_2D_MULTISAMPLE => Some(api::GL_TEXTURE_2D_MULTISAMPLE),
        _ => None,
    }
}

/// Returns the samplers of a linked program.
pub fn of_program(gl: &Gl, program: u32) -> Vec<Sampler> {
    let mut count = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_programiv(program, api::GL_ACTIVE_UNIFORMS, &mut count) };
    let mut found = Vec::new();
    for index in 0..u32::try_from(count).unwrap_or(0) {
        let mut text: [c_char; 256] = [0; 256];
        let (mut length, mut size, mut kind) = (0, 0, 0);
        // SAFETY: writes at most 256 characters with their NUL, which are the name for the
        // location.
        let location = unsafe {
            gl.get_active_uniform(program, index, 256, &mut length, &mut size, &mut kind, text.as_mut_ptr());
            gl.get_uniform_location(program, CStr::from_ptr(text.as_ptr()).as_ptr())
        };
        if let Some(target) = target_of(kind).filter(|_| location >= 0) {
            // The elements of an array have consecutive locations.
            found.extend((location..location + size.max(1)).map(|location| Sampler { location, target }));
        }
    }
    found
}
