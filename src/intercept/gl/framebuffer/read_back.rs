//! What a program reads from its window: from the primary picture, which is its own.

use crate::backend::gl::api::Gl;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::framebuffer::default_framebuffer;
use crate::intercept::gl::offscreen::view_copies;
use std::ffi::c_void;

/// Binds what reads of the window come from; the origin of the window's picture in it.
pub fn prepare(ctx: &mut Context) -> [i32; 2] {
    default_framebuffer::bind_for_reading(ctx)
}

/// Puts the read framebuffer back.
pub fn finish(ctx: &mut Context) {
    default_framebuffer::end_reading(ctx);
}

/// Runs a read of the program, with its rectangle's origin moved to where its picture is.
pub fn read<R>(ctx: &mut Context, x: i32, y: i32, issue: impl FnOnce(i32, i32) -> R) -> R {
    if !ctx.reads_redirected() {
        view_copies::before_reading_framebuffer(ctx);
        return issue(x, y);
    }
    let origin = prepare(ctx);
    let answer = issue(x + origin[0], y + origin[1]);
    finish(ctx);
    answer
}

/// Runs a copy into a texture, which may be a part of a display list.
fn copy(ctx: &mut Context, [x, y]: [i32; 2], issue: impl Fn(&Gl, i32, i32) + Send + Sync + 'static) {
    list_recording::now_or_later(ctx, move |ctx| {
        let gl = ctx.driver.gl;
        read(ctx, x, y, |x, y| issue(gl, x, y));
    });
}

hooks! {
    "glReadPixels" read_pixels(x: i32, y: i32, w: i32, h: i32, format: u32, kind: u32, pixels: *mut c_void) = |ctx, gl|
        read(ctx, x, y, |x, y| gl.read_pixels(x, y, w, h, format, kind, pixels));
    "glReadnPixels" readn_pixels(x: i32, y: i32, w: i32, h: i32, format: u32, kind: u32, size: i32, pixels: *mut c_void) = |ctx, gl|
        read(ctx, x, y, |x, y| gl.readn_pixels(x, y, w, h, format, kind, size, pixels));
    "glCopyTexImage1D" copy_tex_image1_d(target: u32, level: i32, format: u32, x: i32, y: i32, w: i32, border: i32) = |ctx, _gl|
        copy(ctx, [x, y], move |gl, x, y| gl.copy_tex_image1_d(target, level, format, x, y, w, border));
    "glCopyTexSubImage1D" copy_tex_sub_image1_d(target: u32, level: i32, dx: i32, x: i32, y: i32, w: i32) = |ctx, _gl|
        copy(ctx, [x, y], move |gl, x, y| gl.copy_tex_sub_image1_d(target, level, dx, x, y, w));
    "glCopyTexSubImage3D" copy_tex_sub_image3_d(target: u32, level: i32, dx: i32, dy: i32, dz: i32, x: i32, y: i32, w: i32, h: i32) = |ctx, _gl|
        copy(ctx, [x, y], move |gl, x, y| gl.copy_tex_sub_image3_d(target, level, dx, dy, dz, x, y, w, h));
}
