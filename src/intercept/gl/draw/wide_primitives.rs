//! Points and lines that are wider than the space between two tiles.
//!
//! A viewport cuts triangles, but of a point or a line only its middle: the rest would be drawn into the neighbouring
//! tile. Changing the scissor with each view is dear on software renderers, so tiles are cut for these only.

use crate::backend::gl::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::projected_vertices::tessellation::Patch;

/// What a draw consists of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// Anything: a display list, say.
    #[default]
    Unknown,
    /// Points.
    Points,
    /// Lines.
    Lines,
    /// Triangles, strips or fans of them.
    Triangles,
    /// Quadrilaterals, strips of them, or polygons.
    Filled,
}

impl Shape {
    /// Of a draw of this mode.
    pub fn of_mode(mode: u32) -> Self {
        match mode {
            api::GL_POINTS => Self::Points,
            api::GL_LINES
            | api::GL_LINE_LOOP
            | api::GL_LINE_STRIP
            | api::GL_LINES_ADJACENCY
            | api::GL_LINE_STRIP_ADJACENCY => Self::Lines,
            api::GL_TRIANGLES..=api::GL_TRIANGLE_FAN => Self::Triangles,
            api::GL_QUADS..=api::GL_POLYGON => Self::Filled,
            _ => Self::Unknown,
        }
    }
}

/// How the program draws outlines.
#[derive(Default)]
pub struct Outlines {
    /// What the next draw consists of, where its hook knows.
    pub shape: Shape,
    /// What the draw that is being issued consists of.
    pub drawn: Shape,
    /// The mode of the next draw, where its hook can issue it as patches.
    pub mode: Option<u32>,
    /// The patches that the draw that is being issued can be issued as.
    pub patch: Option<Patch>,
    /// It is issued as these now.
    pub as_patches: bool,
    /// `glPolygonMode` was another than `GL_FILL`. It counts for good: a list or a pop may bring it back.
    polygons: bool,
    /// The draw that is being issued may leave its tile.
    pub cut: bool,
}

impl Outlines {
    /// What a hook issues a draw of `mode` as.
    pub fn issued(&self, mode: u32) -> u32 {
        if self.as_patches { api::GL_PATCHES } else { mode }
    }

    /// Polygons may be drawn as outlines.
    pub fn may_outline(&self) -> bool {
        self.polygons
    }
}

/// Finds out whether the next draw may leave its tile.
pub fn look(ctx: &mut Context) {
    let shape = std::mem::take(&mut ctx.outlines.shape);
    ctx.outlines.drawn = shape;
    ctx.outlines.patch = match ctx.outlines.mode.take() {
        Some(api::GL_TRIANGLES) => Some(Patch::Triangles),
        Some(api::GL_LINES) => Some(Patch::Lines),
        Some(api::GL_QUADS) => Some(Patch::Quads),
        _ => None,
    };
    let emits = ctx.program.as_ref().is_some_and(|p| p.stages() & api::GL_GEOMETRY_SHADER_BIT != 0);
    let wide = ctx.widest.exceeds_gutter();
    ctx.outlines.cut = match shape {
        _ if emits => wide,
        Shape::Unknown | Shape::Lines => wide,
        // Shaders of OpenGL ES always set the size of points.
        Shape::Points => wide || ctx.profile.es,
        Shape::Triangles | Shape::Filled => wide && ctx.outlines.polygons,
    };
}

hooks! {
    "glPolygonMode" polygon_mode(face: u32, mode: u32) = |ctx, gl| {
        ctx.outlines.polygons |= mode != api::GL_FILL;
        gl.polygon_mode(face, mode);
    };
}

#[cfg(test)]
mod tests {
    use super::{Shape, api};

    #[test]
    fn modes_have_shapes() {
        assert_eq!(Shape::of_mode(api::GL_POINTS), Shape::Points);
        assert_eq!(Shape::of_mode(api::GL_LINE_STRIP), Shape::Lines);
        assert_eq!(Shape::of_mode(api::GL_QUAD_STRIP), Shape::Filled);
        assert_eq!(Shape::of_mode(api::GL_PATCHES), Shape::Unknown);
    }
}
