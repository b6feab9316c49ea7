//! Triangles over an output. Each corner has a direction and a weight.

use glam::{DVec2, DVec3};

/// A corner of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetCorner {
    /// Place in the output, pixels from the top left; may be outside of it.
    pub place: DVec2,
    /// Direction from the viewer, viewer axes, any length. It is interpolated without
    /// normalisation.
    pub direction: DVec3,
    /// Weight in linear light, 0…1: product of all weights except masks.
    pub weight: f64,
}

/// Triangles over an output.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facets {
    /// The corners of all triangles.
    pub corners: Vec<FacetCorner>,
    /// Indices of the three corners of each triangle. Triangles do not overlap.
    pub triangles: Vec<[u32; 3]>,
    /// True if the triangles fill the rectangles that they replace. Otherwise the output is made
    /// black first.
    pub fills: bool,
    /// True if the corners are drawn at their places in the atlas of the only view of their batch, so
    /// that the shader has no numbers of the rig.
    pub is_rough: bool,
    /// The greatest error that was measured between corners, pixels of the output.
    pub error: f64,
}

impl Facets {
    /// True if some weight is not 1, or may not be.
    pub fn is_weighted(&self) -> bool {
        self.is_rough || self.corners.iter().any(|corner| corner.weight != 1.0)
    }
}
