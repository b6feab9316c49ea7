//! Programs that show their drawing without a swap: windows with one buffer, and drawing to the
//! front buffer.
//!
//! Such a program ends a picture with `glFlush` or `glFinish`. Each of these calls ends a frame if
//! the program has drawn since the last one.

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::current;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::frame::present;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::process::ending;
use std::time::Instant;

/// Returns true if the program's drawing appears in the window without a swap.
pub fn draws_to_front(app: &AppState, drawable: &Drawable) -> bool {
    let is_front = |name: &u32| {
        matches!(
            *name,
            api::GL_FRONT
                | api::GL_FRONT_LEFT
                | api::GL_FRONT_RIGHT
                | api::GL_FRONT_AND_BACK
                | api::GL_LEFT
                | api::GL_RIGHT
        )
    };
    drawable.target().is_some_and(|t| !t.config().double_buffered || app.buffers().draw().iter().any(is_front))
}

/// Shows what the program has drawn. Pictures that follow each other too fast are left out, unless
/// `finally` is set: then the program waits for the drawing.
pub fn show(ctx: &mut Context, finally: bool) {
    let drawing = ctx.compiling() || ctx.compat.under_way() || ctx.app.picking();
    if ctx.frame.begun()
        && !drawing
        && !ending::has_begun()
        && draws_to_front(&ctx.app, &ctx.drawable)
        && (ctx.frame.front_buffer_is_due(Instant::now()) || finally)
    {
        present::show_front(ctx);
    }
}

/// Does the same as [`show`] for calls of the window system that wait for OpenGL.
pub fn show_current() {
    let Some(ctx) = current::current().filter(|c| !c.switched_off) else { return };
    if crate::fence::guard(|| show(ctx, true)).is_none() {
        current::after_panic("showing the front buffer");
    }
}

hooks! {
    "glFlush" flush() = |ctx, gl| {
        show(ctx, false);
        gl.flush();
    };
    "glFinish" finish() = |ctx, gl| {
        show(ctx, true);
        gl.finish();
    };
}
