//! Calls of our own in the context of the program.

use crate::backend::gl::api;
use crate::intercept::gl::context::gl_context::Context;

/// Runs work of ours, which is done whatever the program's condition says.
pub fn unconditionally<R>(ctx: &mut Context, work: impl FnOnce(&mut Context) -> R) -> R {
    let Some((query, mode)) = ctx.condition else { return work(ctx) };
    // SAFETY: conditional rendering is in force, as its hook saw; it is put back.
    unsafe { ctx.gl.end_conditional_render() };
    let answer = work(ctx);
    // SAFETY: the object and mode that were in force.
    unsafe { ctx.gl.begin_conditional_render(query, mode) };
    answer
}

/// Runs work of ours, which is neither counted nor told of nor subject to the program's conditional rendering.
pub fn aside<R>(ctx: &mut Context, work: impl FnOnce(&mut Context) -> R) -> R {
    let gl = ctx.gl;
    for running in &mut ctx.queries.running {
        running.end_part(gl);
    }
    let answer = quietly(ctx, |ctx| unconditionally(ctx, work));
    for number in 0..ctx.queries.running.len() {
        ctx.queries.begin_part(gl, number, None);
    }
    answer
}

/// Runs work of ours without the program's debug callback.
pub fn quietly<R>(ctx: &mut Context, work: impl FnOnce(&mut Context) -> R) -> R {
    let gl = ctx.gl;
    let knows = ctx.profile.version >= if ctx.profile.es { 32 } else { 43 };
    let talks = knows && ctx.known_state.is_on(gl, api::GL_DEBUG_OUTPUT);
    if talks {
        // SAFETY: a switch that this version has; it is put back.
        unsafe { gl.disable(api::GL_DEBUG_OUTPUT) };
        ctx.known_state.note(api::GL_DEBUG_OUTPUT, false);
    }
    let answer = work(ctx);
    if talks {
        // SAFETY: as above.
        unsafe { gl.enable(api::GL_DEBUG_OUTPUT) };
        ctx.known_state.note(api::GL_DEBUG_OUTPUT, true);
    }
    answer
}
