//! Points and lines that are wider than the space between two tiles.
//!
//! A viewport clips triangles, but of a point or a line only its middle. The rest would be drawn
//! into the neighbouring tile. A change of the scissor for each view is slow on software renderers,
//! so only these primitives are cut at their tile.

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::state::draw::DrawState;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::shader::Shaders;

/// Determines whether the next draw may reach beyond its tile.
pub fn look(driver: &Driver, draw: &mut DrawState, shaders: &Shaders) {
    let emits = shaders.program().is_some_and(|p| p.stages() & api::GL_GEOMETRY_SHADER_BIT != 0);
    draw.begin(emits, driver.profile.es);
}

hooks! {
    "glPolygonMode" polygon_mode(face: u32, mode: u32) = |ctx, gl| {
        ctx.draw.note_polygon_mode(mode);
        gl.polygon_mode(face, mode);
    };
}
