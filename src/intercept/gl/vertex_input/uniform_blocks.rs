//! Buffers that may hold uniform blocks.

use crate::backend::gl::api;
use crate::intercept::gl::context::gl_context::Context;

/// A buffer changed. Where it may be a uniform block its matrices are read back, which is a wait for the driver; a
/// program that streams vertices must not have it.
pub fn buffer_changed(ctx: &mut Context, buffer: u32) {
    ctx.vertex_input.blocks.changed(buffer);
}

/// A buffer was bound to an indexed binding point; 0: it was taken away.
pub fn buffer_bound(ctx: &mut Context, target: u32, buffer: u32) {
    if target == api::GL_UNIFORM_BUFFER {
        ctx.vertex_input.blocks.bound(buffer);
    }
}
