//! Commands on textures and renderbuffers that change, copy or read images which may have per-view
//! copies.

use crate::backend::gl::driver::api;
use crate::correct::{LowerLeftRect, Size};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::framebuffer::commands::{summed_pixels, window_answers};
use crate::intercept::gl::framebuffer::reading::read_back;
use crate::intercept::gl::offscreen::{sampling, transfers, view_copies};
use std::ffi::c_void;

/// Returns the texture that is bound at `target` if its images are followed; 0 = none.
fn bound(ctx: &Context, target: u32) -> u32 {
    if ctx.view_copies.any() && !ctx.compiling() { sampling::bound(&ctx.driver, target) } else { 0 }
}

/// True if the program reads its window, which has no alpha, into a texture format with alpha.
/// OpenGL ES refuses that. Cupola's stand-in image has alpha.
fn lacks_alpha(ctx: &Context, format: u32) -> bool {
    const WITHOUT_ALPHA: [u32; 9] = [
        api::GL_RED,
        api::GL_RG,
        api::GL_RGB,
        api::GL_LUMINANCE,
        api::GL_R8,
        api::GL_RG8,
        api::GL_RGB8,
        api::GL_RGB565,
        api::GL_SRGB8,
    ];
    let window_has_alpha = || ctx.drawable.target().is_none_or(|target| target.config().alpha_bits > 0);
    ctx.driver.profile.es && ctx.reads_redirected() && !WITHOUT_ALPHA.contains(&format) && !window_has_alpha()
}

/// Handles a call that sets the size of a texture level. `filled`: the call also sets its texels.
fn specified(ctx: &mut Context, texture: u32, level: i32, size: Size, issue: impl FnOnce(), filled: bool) {
    let same = texture != 0 && view_copies::is_alike(&ctx.view_copies, texture, level, size);
    if texture != 0 && !same {
        view_copies::forget_texture(ctx, texture);
    }
    issue();
    if same && filled {
        view_copies::uploaded(ctx, texture);
    }
}

/// Notes that a texture gets new storage.
fn stored(ctx: &mut Context, texture: u32) {
    if texture != 0 {
        view_copies::forget_texture(ctx, texture);
    }
}

/// Notes that the bound renderbuffer gets new storage.
fn stored_bound_renderbuffer(ctx: &mut Context) {
    if ctx.view_copies.any() {
        let mut renderbuffer = 0;
        // SAFETY: writes one integer.
        unsafe { ctx.driver.gl.get_integerv(api::GL_RENDERBUFFER_BINDING, &mut renderbuffer) };
        view_copies::forget_renderbuffer(ctx, renderbuffer as u32);
    }
}

/// Handles a copy from the read framebuffer into a level of a texture. Both may have per-view
/// copies.
fn copied(
    ctx: &mut Context,
    texture: u32,
    level: i32,
    offset: [i32; 2],
    source: LowerLeftRect,
    issue: impl FnOnce(&mut Context),
) {
    if texture != 0 && transfers::into_texture(ctx, texture, level, offset, source) {
        return;
    }
    issue(ctx);
    if texture != 0 {
        transfers::noted_into_texture(ctx, texture, level, source);
    }
}

hooks! {
    "glTexImage2D" tex_image2_d(target: u32, level: i32, internal: i32, w: i32, h: i32, border: i32, format: u32, kind: u32, pixels: *const c_void) = |ctx, gl| {
        if target != api::GL_PROXY_TEXTURE_2D {
            summed_pixels::add(&ctx.driver, Size::new(w, h), (format, kind), pixels);
        }
        let texture = bound(ctx, target);
        specified(ctx, texture, level, Size::new(w, h), || gl.tex_image2_d(target, level, internal, w, h, border, format, kind, pixels), !pixels.is_null());
    };
    "glTexSubImage2D" tex_sub_image2_d(target: u32, level: i32, x: i32, y: i32, w: i32, h: i32, format: u32, kind: u32, pixels: *const c_void) = |ctx, gl| {
        summed_pixels::add(&ctx.driver, Size::new(w, h), (format, kind), pixels);
        gl.tex_sub_image2_d(target, level, x, y, w, h, format, kind, pixels);
        view_copies::uploaded(ctx, bound(ctx, target));
    };
    "glTextureSubImage2D" texture_sub_image2_d(texture: u32, level: i32, x: i32, y: i32, w: i32, h: i32, format: u32, kind: u32, pixels: *const c_void) = |ctx, gl| {
        summed_pixels::add(&ctx.driver, Size::new(w, h), (format, kind), pixels);
        gl.texture_sub_image2_d(texture, level, x, y, w, h, format, kind, pixels);
        view_copies::uploaded(ctx, texture);
    };
    "glTexImage2DMultisample" tex_image2_d_multisample(target: u32, samples: i32, internal: u32, w: i32, h: i32, fixed: u8) = |ctx, gl| {
        let texture = bound(ctx, target);
        stored(ctx, texture);
        gl.tex_image2_d_multisample(target, samples, internal, w, h, fixed);
    };
    "glTexStorage2D" tex_storage2_d(target: u32, levels: i32, internal: u32, w: i32, h: i32) = |ctx, gl| {
        let texture = bound(ctx, target);
        stored(ctx, texture);
        gl.tex_storage2_d(target, levels, internal, w, h);
    };
    "glTextureStorage2D" texture_storage2_d(texture: u32, levels: i32, internal: u32, w: i32, h: i32) = |ctx, gl| {
        stored(ctx, texture);
        gl.texture_storage2_d(texture, levels, internal, w, h);
    };
    "glRenderbufferStorage" renderbuffer_storage(target: u32, internal: u32, w: i32, h: i32) = |ctx, gl| {
        stored_bound_renderbuffer(ctx);
        gl.renderbuffer_storage(target, internal, w, h);
    };
    "glRenderbufferStorageMultisample" renderbuffer_storage_multisample(target: u32, samples: i32, internal: u32, w: i32, h: i32) = |ctx, gl| {
        stored_bound_renderbuffer(ctx);
        gl.renderbuffer_storage_multisample(target, samples, internal, w, h);
    };
    "glNamedRenderbufferStorage" named_renderbuffer_storage(renderbuffer: u32, internal: u32, w: i32, h: i32) = |ctx, gl| {
        view_copies::forget_renderbuffer(ctx, renderbuffer);
        gl.named_renderbuffer_storage(renderbuffer, internal, w, h);
    };
    "glNamedRenderbufferStorageMultisample" named_renderbuffer_storage_multisample(renderbuffer: u32, samples: i32, internal: u32, w: i32, h: i32) = |ctx, gl| {
        view_copies::forget_renderbuffer(ctx, renderbuffer);
        gl.named_renderbuffer_storage_multisample(renderbuffer, samples, internal, w, h);
    };
    "glGenerateMipmap" generate_mipmap(target: u32) = |ctx, gl| {
        let texture = bound(ctx, target);
        if texture == 0 || !view_copies::mipmaps(&mut ctx.view_copies, texture) { gl.generate_mipmap(target) }
    };
    "glGenerateTextureMipmap" generate_texture_mipmap(texture: u32) = |ctx, gl| {
        if !view_copies::mipmaps(&mut ctx.view_copies, texture) { gl.generate_texture_mipmap(texture) }
    };
    "glGetTexImage" get_tex_image(target: u32, level: i32, format: u32, kind: u32, pixels: *mut c_void) = |ctx, gl| {
        let texture = bound(ctx, target);
        view_copies::before_reading_texture(ctx, texture);
        gl.get_tex_image(target, level, format, kind, pixels);
    };
    "glGetTextureImage" get_texture_image(texture: u32, level: i32, format: u32, kind: u32, size: i32, pixels: *mut c_void) = |ctx, gl| {
        view_copies::before_reading_texture(ctx, texture);
        gl.get_texture_image(texture, level, format, kind, size, pixels);
    };
    "glCopyTexImage2D" copy_tex_image2_d(target: u32, level: i32, format: u32, x: i32, y: i32, w: i32, h: i32, border: i32) = |ctx, _gl|
        list_recording::now_or_later(ctx, move |ctx| {
            let gl = ctx.driver.gl;
            if lacks_alpha(ctx, format) {
                // The driver reports an error.
                // SAFETY: the program's own call.
                window_answers::with_own(ctx, api::GL_READ_FRAMEBUFFER, |gl| unsafe {
                    gl.copy_tex_image2_d(target, level, format, x, y, w, h, border);
                });
                return;
            }
            let texture = sampling::bound(&ctx.driver, target);
            if texture != 0 && !view_copies::is_alike(&ctx.view_copies, texture, level, Size::new(w, h)) {
                view_copies::forget_texture(ctx, texture);
            }
            copied(ctx, texture, level, [0, 0], LowerLeftRect::new(x, y, w, h), |ctx| {
                // SAFETY: the program's own call, with the coordinates of its picture in the atlas.
                read_back::read(ctx, LowerLeftRect::new(x, y, w, h), true, |x, y| unsafe { gl.copy_tex_image2_d(target, level, format, x, y, w, h, border) });
            });
        });
    "glCopyTexSubImage2D" copy_tex_sub_image2_d(target: u32, level: i32, dx: i32, dy: i32, x: i32, y: i32, w: i32, h: i32) = |ctx, _gl|
        list_recording::now_or_later(ctx, move |ctx| {
            let gl = ctx.driver.gl;
            let texture = sampling::bound(&ctx.driver, target);
            copied(ctx, texture, level, [dx, dy], LowerLeftRect::new(x, y, w, h), |ctx| {
                // SAFETY: as above.
                read_back::copy_part(ctx, LowerLeftRect::new(x, y, w, h), |r, [u, v]| unsafe {
                    gl.copy_tex_sub_image2_d(target, level, dx + u, dy + v, r.x, r.y, r.width, r.height);
                });
            });
        });
    "glCopyTextureSubImage2D" copy_texture_sub_image2_d(texture: u32, level: i32, dx: i32, dy: i32, x: i32, y: i32, w: i32, h: i32) = |ctx, gl| {
        if ctx.compiling() {
            // Mesa executes the call at once; another driver makes it part of the display list.
            gl.copy_texture_sub_image2_d(texture, level, dx, dy, x, y, w, h);
        } else {
            copied(ctx, texture, level, [dx, dy], LowerLeftRect::new(x, y, w, h), |ctx| {
                read_back::copy_part(ctx, LowerLeftRect::new(x, y, w, h), |r, [u, v]| {
                    gl.copy_texture_sub_image2_d(texture, level, dx + u, dy + v, r.x, r.y, r.width, r.height);
                });
            });
        }
    };
    "glDeleteTextures" delete_textures(count: i32, names: *const u32) = |ctx, gl| {
        if ctx.view_copies.any() && !names.is_null() {
            for name in std::slice::from_raw_parts(names, usize::try_from(count).unwrap_or(0)) {
                view_copies::forget_texture(ctx, *name);
            }
        }
        gl.delete_textures(count, names);
    };
    "glDeleteRenderbuffers" delete_renderbuffers(count: i32, names: *const u32) = |ctx, gl| {
        if ctx.view_copies.any() && !names.is_null() {
            for name in std::slice::from_raw_parts(names, usize::try_from(count).unwrap_or(0)) {
                view_copies::forget_renderbuffer(ctx, *name);
            }
        }
        gl.delete_renderbuffers(count, names);
    };
}
