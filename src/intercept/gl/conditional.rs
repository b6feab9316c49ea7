//! Conditional rendering: it holds for what the program draws, not for our own work in between.

use super::context::Context;
use super::default_framebuffer::take_error;
use super::hook::hooks;
use crate::backend::gl::api;

/// The query and the mode of `glBeginConditionalRender`, while it is in force.
pub type Condition = Option<(u32, u32)>;

/// Runs work of ours, which is done whatever the program's condition says.
pub fn unconditionally<R>(ctx: &mut Context, work: impl FnOnce(&mut Context) -> R) -> R {
    let Some((query, mode)) = ctx.condition else { return work(ctx) };
    // SAFETY: conditional rendering is in force, as its hook saw; it is put back.
    unsafe { ctx.gl.end_conditional_render() };
    let answer = work(ctx);
    // SAFETY: the program's own query and mode.
    unsafe { ctx.gl.begin_conditional_render(query, mode) };
    answer
}

hooks! {
    "glBeginConditionalRender" begin_conditional_render(query: u32, mode: u32) = |ctx, gl| {
        // Whether the driver takes it is told by its error only.
        take_error(ctx);
        gl.begin_conditional_render(query, mode);
        match gl.get_error() {
            api::GL_NO_ERROR => ctx.condition = Some((query, mode)),
            error if ctx.pending_error == api::GL_NO_ERROR => ctx.pending_error = error,
            _ => {}
        }
    };
    "glEndConditionalRender" end_conditional_render() = |ctx, gl| {
        gl.end_conditional_render();
        ctx.condition = None;
    };
}
