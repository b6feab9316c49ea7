//! Points and lines that are wider than the space between two tiles.
//!
//! A viewport clips triangles, but of a point or a line only its middle. The rest would be drawn
//! into the neighbouring tile. A change of the scissor for each view is slow on software renderers,
//! so only these primitives are cut at their tile.

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;

/// Determines whether the next draw may reach beyond its tile.
pub fn look(ctx: &mut Context) {
    let emits = ctx.shaders.program().is_some_and(|p| p.stages() & api::GL_GEOMETRY_SHADER_BIT != 0);
    ctx.draw.begin(emits, ctx.driver.profile.es);
}

hooks! {
    "glPolygonMode" polygon_mode(face: u32, mode: u32) = |ctx, gl| {
        ctx.draw.note_polygon_mode(mode);
        gl.polygon_mode(face, mode);
    };
}
