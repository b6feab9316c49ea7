//! Primitives of the next draw, and of the one that is being issued.

use crate::backend::gl::driver::api;

/// Kind of primitives of a draw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// Any primitives, for example those of a display list.
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
    /// Returns the shape that draws of this mode make.
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

/// State of primitives that may be wide or drawn as outlines.
#[derive(Default)]
pub(super) struct WidePrimitives {
    /// Primitives of the next draw, if its hook knows them.
    pub(super) shape: Shape,
    /// Primitives of the draw that is being issued.
    pub(super) drawn: Shape,
    /// Mode of the next draw, if its hook can issue it as patches.
    pub(super) mode: Option<u32>,
    /// Patches as which the present draw can be issued.
    pub(super) patch: Option<Patch>,
    /// True while the draw is issued as patches.
    pub(super) as_patches: bool,
    /// True once `glPolygonMode` was not `GL_FILL`. This is never forgotten, as a display list or
    /// `glPopAttrib` may restore it.
    pub(super) polygons: bool,
    /// True if the draw that is being issued may leave its tile.
    pub(super) cut: bool,
}

impl WidePrimitives {
    /// Begins a draw. `wide`: points and lines may be wider than the gutter between tiles. `emits`:
    /// a geometry shader makes the primitives. `es`: the context has OpenGL ES.
    pub(super) fn begin(&mut self, wide: bool, emits: bool, es: bool) {
        let shape = std::mem::take(&mut self.shape);
        self.drawn = shape;
        self.patch = match self.mode.take() {
            Some(api::GL_TRIANGLES) => Some(Patch::Triangles),
            Some(api::GL_LINES) => Some(Patch::Lines),
            Some(api::GL_QUADS) => Some(Patch::Quads),
            _ => None,
        };
        self.cut = match shape {
            _ if emits => wide,
            Shape::Unknown | Shape::Lines => wide,
            // In OpenGL ES shaders always set the size of points.
            Shape::Points => wide || es,
            Shape::Triangles | Shape::Filled => wide && self.polygons,
        };
    }
}

/// Primitive that is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Patch {
    /// Triangles, each with three vertices of its own.
    Triangles,
    /// Lines, each with two vertices of its own.
    Lines,
    /// Quadrilaterals, each with four vertices of its own.
    Quads,
}

impl Patch {
    /// Returns the number of vertices of a patch.
    pub fn corners(self) -> usize {
        match self {
            Self::Triangles => 3,
            Self::Lines => 2,
            Self::Quads => 4,
        }
    }

    /// Returns the layout of the evaluation stage that divides the patch. The corners of the parts
    /// have the same order of rotation as those of the patch.
    pub(in crate::intercept::gl) fn layout(self) -> &'static str {
        match self {
            Self::Triangles => "triangles, equal_spacing, ccw",
            Self::Lines => "isolines, equal_spacing",
            Self::Quads => "quads, equal_spacing, ccw",
        }
    }

    /// Returns the edge of each outer level (OpenGL 4.0, section 2.12.2).
    pub(in crate::intercept::gl) fn edges(self) -> &'static [[usize; 2]] {
        match self {
            Self::Triangles => &[[1, 2], [2, 0], [0, 1]],
            Self::Lines => &[[0, 1]],
            Self::Quads => &[[3, 0], [0, 1], [1, 2], [2, 3]],
        }
    }

    /// Returns the weights of the corners at a point of the patch.
    pub(in crate::intercept::gl) fn weights(self) -> [&'static str; 4] {
        match self {
            Self::Triangles => ["gl_TessCoord.x", "gl_TessCoord.y", "gl_TessCoord.z", "0.0"],
            Self::Lines => ["1.0 - gl_TessCoord.x", "gl_TessCoord.x", "0.0", "0.0"],
            Self::Quads => [
                "(1.0 - gl_TessCoord.x) * (1.0 - gl_TessCoord.y)",
                "gl_TessCoord.x * (1.0 - gl_TessCoord.y)",
                "gl_TessCoord.x * gl_TessCoord.y",
                "(1.0 - gl_TessCoord.x) * gl_TessCoord.y",
            ],
        }
    }
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
