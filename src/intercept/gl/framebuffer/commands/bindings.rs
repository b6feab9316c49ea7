//! Framebuffers: the program's 0 is ours; bindings and attachments.

use crate::backend::gl::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::offscreen::view_copies;

/// Binds what the program's framebuffer `name` stands for.
pub fn bind(ctx: &mut Context, target: u32, name: u32) {
    let was_redirected = ctx.redirected();
    let ours = ctx.drawable.target().map_or(0, |t| t.framebuffer());
    let real = if name == 0 { ours } else { name };
    let draws = matches!(target, api::GL_FRAMEBUFFER | api::GL_DRAW_FRAMEBUFFER);
    let was_redirected = was_redirected || (draws && view_copies::rebound(&mut ctx.view_copies));
    let reads = matches!(target, api::GL_FRAMEBUFFER | api::GL_READ_FRAMEBUFFER);
    // SAFETY: the program's own call, with our framebuffer in place of its window's.
    unsafe {
        ctx.driver.gl.bind_framebuffer(target, real);
        if reads && name == 0 && ctx.drawable.reads_elsewhere {
            ctx.driver.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, 0);
        }
    }
    if draws {
        ctx.app.draw_framebuffer = name;
    }
    if reads {
        ctx.app.read_framebuffer = name;
    }
    if was_redirected && !ctx.redirected() {
        ctx.restore_window_space();
    }
}

/// Whether `target` is the window, to which nothing can be attached; the program then has its error.
fn refuses_attachments(ctx: &mut Context, target: u32) -> bool {
    let reads = target == api::GL_READ_FRAMEBUFFER;
    let window = if reads { ctx.reads_redirected() } else { ctx.redirected() };
    let changed = if reads { ctx.app.read_framebuffer } else { ctx.app.draw_framebuffer };
    view_copies::forget(ctx, changed);
    if window {
        ctx.driver.note_error(api::GL_INVALID_OPERATION);
    }
    window
}

hooks! {
    "glBindFramebuffer" bind_framebuffer(target: u32, name: u32) = |ctx, _gl| bind(ctx, target, name);
    // A window's buffers cannot be replaced; without us the driver would say so.
    "glFramebufferTexture" framebuffer_texture(target: u32, attachment: u32, texture: u32, level: i32) = |ctx, gl| {
        if !refuses_attachments(ctx, target) { gl.framebuffer_texture(target, attachment, texture, level) }
    };
    "glFramebufferTexture2D" framebuffer_texture2_d(target: u32, attachment: u32, kind: u32, texture: u32, level: i32) = |ctx, gl| {
        if !refuses_attachments(ctx, target) { gl.framebuffer_texture2_d(target, attachment, kind, texture, level) }
    };
    "glFramebufferTextureLayer" framebuffer_texture_layer(target: u32, attachment: u32, texture: u32, level: i32, layer: i32) = |ctx, gl| {
        if !refuses_attachments(ctx, target) { gl.framebuffer_texture_layer(target, attachment, texture, level, layer) }
    };
    "glFramebufferRenderbuffer" framebuffer_renderbuffer(target: u32, attachment: u32, kind: u32, name: u32) = |ctx, gl| {
        if !refuses_attachments(ctx, target) { gl.framebuffer_renderbuffer(target, attachment, kind, name) }
    };
    "glDeleteFramebuffers" delete_framebuffers(count: i32, names: *const u32) = |ctx, gl| {
        let deleted: Vec<u32> = if names.is_null() { Vec::new() } else {
            std::slice::from_raw_parts(names, usize::try_from(count).unwrap_or(0)).to_vec()
        };
        for name in &deleted {
            view_copies::delete(ctx, *name);
        }
        gl.delete_framebuffers(count, names);
        // Deleting the bound framebuffer binds the window's, which is ours.
        if ctx.app.draw_framebuffer != 0 && deleted.contains(&ctx.app.draw_framebuffer) {
            bind(ctx, api::GL_DRAW_FRAMEBUFFER, 0);
        }
        if ctx.app.read_framebuffer != 0 && deleted.contains(&ctx.app.read_framebuffer) {
            bind(ctx, api::GL_READ_FRAMEBUFFER, 0);
        }
    };
    "glIsFramebuffer" is_framebuffer(name: u32) -> u8 = |ctx, gl| {
        if ctx.drawable.target().is_some_and(|t| t.is_ours(name)) { 0 } else { gl.is_framebuffer(name) }
    };
}
