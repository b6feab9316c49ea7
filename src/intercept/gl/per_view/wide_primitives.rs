//! Points and lines that are wider than the space between two tiles.
//!
//! A viewport clips triangles, but of a point or a line only its middle. The rest would be drawn
//! into the neighbouring tile. A change of the scissor for each view is slow on software renderers,
//! so only these primitives are cut at their tile.

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::state::draw::primitives::{Patch, Shape};

/// Determines whether the next draw may reach beyond its tile.
pub fn look(ctx: &mut Context) {
    let shape = std::mem::take(&mut ctx.draw.wide_primitives.shape);
    ctx.draw.wide_primitives.drawn = shape;
    ctx.draw.wide_primitives.patch = match ctx.draw.wide_primitives.mode.take() {
        Some(api::GL_TRIANGLES) => Some(Patch::Triangles),
        Some(api::GL_LINES) => Some(Patch::Lines),
        Some(api::GL_QUADS) => Some(Patch::Quads),
        _ => None,
    };
    let emits = ctx.shaders.program.as_ref().is_some_and(|p| p.stages() & api::GL_GEOMETRY_SHADER_BIT != 0);
    let wide = ctx.draw.max_width.exceeds_gutter();
    ctx.draw.wide_primitives.cut = match shape {
        _ if emits => wide,
        Shape::Unknown | Shape::Lines => wide,
        // In OpenGL ES shaders always set the size of points.
        Shape::Points => wide || ctx.driver.profile.es,
        Shape::Triangles | Shape::Filled => wide && ctx.draw.wide_primitives.polygons,
    };
}

hooks! {
    "glPolygonMode" polygon_mode(face: u32, mode: u32) = |ctx, gl| {
        ctx.draw.wide_primitives.polygons |= mode != api::GL_FILL;
        gl.polygon_mode(face, mode);
    };
}
