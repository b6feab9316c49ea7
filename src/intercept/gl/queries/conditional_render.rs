//! Conditional rendering. It applies to the drawing of the program, not to internal drawing of
//! Cupola.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::queries::scaling;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::queries::Queries;

fn begin(driver: &mut Driver, queries: &mut Queries, query: u32, mode: u32) {
    let object = scaling::condition(driver.gl, queries, query);
    // The error is the only sign whether the driver accepts the call.
    driver.take_errors();
    // SAFETY: the program's own call. If `object` is an object of Cupola, it counted the same draws
    // as the program's query.
    let error = unsafe {
        driver.gl.begin_conditional_render(object, mode);
        driver.gl.get_error()
    };
    match error {
        api::GL_NO_ERROR => queries.condition = Some((object, mode)),
        error => driver.note_error(error),
    }
}

fn end(gl: &Gl, queries: &mut Queries) {
    // SAFETY: the program's own call.
    unsafe { gl.end_conditional_render() };
    queries.condition = None;
}

hooks! {
    "glBeginConditionalRender" begin_conditional_render(query: u32, mode: u32) = |ctx, _gl|
        list_recording::now_or_later(ctx, move |ctx| begin(&mut ctx.driver, &mut ctx.queries, query, mode));
    "glEndConditionalRender" end_conditional_render() = |ctx, _gl| list_recording::now_or_later(ctx, |ctx| end(ctx.driver.gl, &mut ctx.queries));
}
