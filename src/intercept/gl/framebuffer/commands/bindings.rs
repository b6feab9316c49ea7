//! Framebuffer bindings and attachments. The stand-in image replaces the program's framebuffer 0.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::values::integer;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::framebuffer::commands::window_answers;
use crate::intercept::gl::offscreen::view_copies;

/// Binds the program's framebuffer `name`, or the stand-in image for the window.
pub fn bind(ctx: &mut Context, target: u32, name: u32) {
    let was_redirected = ctx.redirected();
    let ours = ctx.drawable.target().map_or(0, |t| t.framebuffer());
    let real = if name == 0 { ours } else { name };
    let draws = matches!(target, api::GL_FRAMEBUFFER | api::GL_DRAW_FRAMEBUFFER);
    let reads = matches!(target, api::GL_FRAMEBUFFER | api::GL_READ_FRAMEBUFFER);
    // SAFETY: the program's own call, with the stand-in framebuffer instead of the window's.
    unsafe { ctx.driver.gl.bind_framebuffer(target, real) };
    let asked = if draws { api::GL_DRAW_FRAMEBUFFER_BINDING } else { api::GL_READ_FRAMEBUFFER_BINDING };
    if (draws || reads) && integer(ctx.driver.gl, asked) != real as i32 {
        // In a core profile the driver refuses names that it has not created. Between glBegin and
        // glEnd it refuses the call, and does not answer the question either. In both cases the
        // binding has not changed.
        return;
    }
    if reads && name == 0 && ctx.drawable.reads_elsewhere() {
        // SAFETY: the window's own framebuffer.
        unsafe { ctx.driver.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, 0) };
    }
    let was_redirected = was_redirected || (draws && view_copies::rebound(&mut ctx.view_copies));
    if draws {
        ctx.app.bind_draw_framebuffer(name);
    }
    if reads {
        ctx.app.bind_read_framebuffer(name);
    }
    if was_redirected && !ctx.redirected() {
        ctx.restore_window_space();
    }
}

/// Attaches an image to the framebuffer that is bound at `target`. For the window the window's own
/// framebuffer gets the call, and reports that nothing can be attached.
fn attach(ctx: &mut Context, target: u32, run: impl FnOnce(&Gl)) {
    let changed =
        if target == api::GL_READ_FRAMEBUFFER { ctx.app.read_framebuffer() } else { ctx.app.draw_framebuffer() };
    view_copies::forget(ctx, changed);
    window_answers::with_own(ctx, target, run);
}

hooks! {
    "glBindFramebuffer" bind_framebuffer(target: u32, name: u32) = |ctx, _gl| bind(ctx, target, name);
    "glFramebufferTexture" framebuffer_texture(target: u32, attachment: u32, texture: u32, level: i32) = |ctx, _gl|
        attach(ctx, target, |gl| gl.framebuffer_texture(target, attachment, texture, level));
    "glFramebufferTexture2D" framebuffer_texture2_d(target: u32, attachment: u32, kind: u32, texture: u32, level: i32) = |ctx, _gl|
        attach(ctx, target, |gl| gl.framebuffer_texture2_d(target, attachment, kind, texture, level));
    "glFramebufferTexture1D" framebuffer_texture1_d(target: u32, attachment: u32, kind: u32, texture: u32, level: i32) = |ctx, _gl|
        attach(ctx, target, |gl| gl.framebuffer_texture1_d(target, attachment, kind, texture, level));
    "glFramebufferTexture3D" framebuffer_texture3_d(target: u32, attachment: u32, kind: u32, texture: u32, level: i32, layer: i32) = |ctx, _gl|
        attach(ctx, target, |gl| gl.framebuffer_texture3_d(target, attachment, kind, texture, level, layer));
    "glFramebufferTextureLayer" framebuffer_texture_layer(target: u32, attachment: u32, texture: u32, level: i32, layer: i32) = |ctx, _gl|
        attach(ctx, target, |gl| gl.framebuffer_texture_layer(target, attachment, texture, level, layer));
    "glFramebufferRenderbuffer" framebuffer_renderbuffer(target: u32, attachment: u32, kind: u32, name: u32) = |ctx, _gl|
        attach(ctx, target, |gl| gl.framebuffer_renderbuffer(target, attachment, kind, name));
    "glDeleteFramebuffers" delete_framebuffers(count: i32, names: *const u32) = |ctx, gl| {
        let deleted: Vec<u32> = if names.is_null() { Vec::new() } else {
            std::slice::from_raw_parts(names, usize::try_from(count).unwrap_or(0)).to_vec()
        };
        for name in &deleted {
            view_copies::delete(ctx, *name);
        }
        gl.delete_framebuffers(count, names);
        // After deletion of the bound framebuffer the window is bound, so the stand-in framebuffer
        // is needed.
        if ctx.app.draw_framebuffer() != 0 && deleted.contains(&ctx.app.draw_framebuffer()) {
            bind(ctx, api::GL_DRAW_FRAMEBUFFER, 0);
        }
        if ctx.app.read_framebuffer() != 0 && deleted.contains(&ctx.app.read_framebuffer()) {
            bind(ctx, api::GL_READ_FRAMEBUFFER, 0);
        }
    };
    "glIsFramebuffer" is_framebuffer(name: u32) -> u8 = |ctx, gl| {
        if ctx.drawable.target().is_some_and(|t| t.is_ours(name)) { 0 } else { gl.is_framebuffer(name) }
    };
}
