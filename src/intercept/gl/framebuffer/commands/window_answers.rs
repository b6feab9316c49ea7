//! Answers to a program's questions about its window's framebuffer, and hints about it.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::offscreen::view_copies;

/// True if the window is bound at `target`, and the window has a stand-in image.
fn is_window(ctx: &Context, target: u32) -> bool {
    if target == api::GL_READ_FRAMEBUFFER { ctx.reads_redirected() } else { ctx.redirected() }
}

/// Runs a command on the framebuffer that is bound at `target`. For the window the window's own
/// framebuffer is used, which gives the errors and answers that the program expects. It has no
/// drawing of the program.
pub(super) fn with_own<R>(ctx: &Context, target: u32, run: impl FnOnce(&Gl) -> R) -> R {
    let gl = ctx.driver.gl;
    let Some(ours) = ctx.drawable.target().filter(|_| is_window(ctx, target)).map(|t| t.framebuffer()) else {
        return run(gl);
    };
    let point = if target == api::GL_READ_FRAMEBUFFER { target } else { api::GL_DRAW_FRAMEBUFFER };
    // SAFETY: the binding is put back.
    unsafe { gl.bind_framebuffer(point, 0) };
    let answer = run(gl);
    // SAFETY: as above.
    unsafe { gl.bind_framebuffer(point, ours) };
    answer
}

/// Parameters that depend on the read buffer.
const READ_PARAMETERS: [u32; 2] = [api::GL_IMPLEMENTATION_COLOR_READ_TYPE, api::GL_IMPLEMENTATION_COLOR_READ_FORMAT];

hooks! {
    "glGetFramebufferAttachmentParameteriv" get_framebuffer_attachment_parameteriv(target: u32, attachment: u32, name: u32, values: *mut i32) = |ctx, _gl|
        attachment_parameter(ctx, target, attachment, name, values);
    "glFramebufferParameteri" framebuffer_parameteri(target: u32, name: u32, value: i32) = |ctx, _gl|
        with_own(ctx, target, |gl| gl.framebuffer_parameteri(target, name, value));
    "glGetFramebufferParameteriv" get_framebuffer_parameteriv(target: u32, name: u32, values: *mut i32) = |ctx, gl|
        // The window's own framebuffer still has its first read buffer. OpenGL ES refuses the question
        // for windows.
        if !ctx.driver.profile.es && ctx.app.buffers().read() == api::GL_NONE && READ_PARAMETERS.contains(&name) {
            gl.get_framebuffer_parameteriv(target, name, values);
        } else {
            with_own(ctx, target, |gl| gl.get_framebuffer_parameteriv(target, name, values));
        };
    "glInvalidateFramebuffer" invalidate_framebuffer(target: u32, count: i32, attachments: *const u32) = |ctx, _gl|
        with_own(ctx, target, |gl| gl.invalidate_framebuffer(target, count, attachments));
    "glDiscardFramebufferEXT" discard_framebuffer_ext(target: u32, count: i32, attachments: *const u32) = |ctx, _gl|
        with_own(ctx, target, |gl| gl.discard_framebuffer_ext(target, count, attachments));
    "glInvalidateSubFramebuffer" invalidate_sub_framebuffer(target: u32, count: i32, attachments: *const u32, x: i32, y: i32, w: i32, h: i32) = |ctx, _gl|
        with_own(ctx, target, |gl| gl.invalidate_sub_framebuffer(target, count, attachments, x, y, w, h));
}

/// `glGetFramebufferAttachmentParameteriv`.
///
/// # Safety
/// `values` must be null or point at memory for one number, as the program promises OpenGL.
pub unsafe fn attachment_parameter(ctx: &mut Context, target: u32, attachment: u32, name: u32, values: *mut i32) {
    view_copies::leave(ctx);
    // SAFETY: the program's own call, with memory for one number.
    with_own(ctx, target, |gl| unsafe {
        gl.get_framebuffer_attachment_parameteriv(target, attachment, name, values);
    });
}
