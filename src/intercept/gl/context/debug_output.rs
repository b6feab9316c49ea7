//! Messages of the driver (KHR_debug) about our own calls are not for the program.

use crate::backend::gl::api;
use crate::intercept::gl::context::gl_context::Context;

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
