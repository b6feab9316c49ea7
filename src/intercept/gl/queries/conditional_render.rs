//! Conditional rendering: it holds for what the program draws, not for our own work in between.

use crate::backend::gl::api;
use crate::intercept::gl::context::errors::take_error;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::queries::scaling;

fn begin(ctx: &mut Context, query: u32, mode: u32) {
    let object = scaling::condition(ctx, query);
    // Whether the driver takes it is told by its error only.
    take_error(ctx);
    // SAFETY: the program's own call; an object of ours in place of its query saw the same.
    let error = unsafe {
        ctx.driver.gl.begin_conditional_render(object, mode);
        ctx.driver.gl.get_error()
    };
    match error {
        api::GL_NO_ERROR => ctx.queries.condition = Some((object, mode)),
        error if ctx.driver.pending_error == api::GL_NO_ERROR => ctx.driver.pending_error = error,
        _ => {}
    }
}

fn end(ctx: &mut Context) {
    // SAFETY: the program's own call.
    unsafe { ctx.driver.gl.end_conditional_render() };
    ctx.queries.condition = None;
}

hooks! {
    "glBeginConditionalRender" begin_conditional_render(query: u32, mode: u32) = |ctx, _gl|
        list_recording::now_or_later(ctx, move |ctx| begin(ctx, query, mode));
    "glEndConditionalRender" end_conditional_render() = |ctx, _gl| list_recording::now_or_later(ctx, end);
}
