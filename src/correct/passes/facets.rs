//! Triangles over an output whose corners know what is seen there.

use glam::{DVec2, DVec3};

/// A corner of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetCorner {
    /// Place in the output, pixels from the top left; may be outside of it.
    pub place: DVec2,
    /// Direction from the viewer, viewer axes, any length: it is interpolated as it is.
    pub direction: DVec3,
    /// Weight in linear light, 0…1: everything that is known beforehand, except masks.
    pub weight: f64,
}

/// Triangles over an output.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facets {
    /// The corners of all triangles.
    pub corners: Vec<FacetCorner>,
    /// Three corners each, as numbers; no two triangles overlap.
    pub triangles: Vec<[u32; 3]>,
    /// They fill the rectangles that they are drawn in place of. Otherwise the output is made black
    /// before.
    pub fills: bool,
    /// The greatest error that was measured between corners, pixels of the output.
    pub error: f64,
}

impl Facets {
    /// Some weight is not 1.
    pub fn is_weighted(&self) -> bool {
        self.corners.iter().any(|corner| corner.weight != 1.0)
    }
}
