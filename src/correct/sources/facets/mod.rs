//! Triangles over an output whose corners know what is seen there.
//!
//! Between the corners of a triangle direction and weight are linear over the output, and shaders have nothing left to
//! compute but the view and its texel. The error falls with the square of the triangles' size.

mod adaptive;
mod clip;
mod dome;
pub(in crate::correct) mod rims;

use crate::correct::plan::builder::PixelRect;
use crate::correct::sources::surface_sample::{Shown, Sight};
use glam::{DVec2, DVec3};

pub(in crate::correct) use dome::dome_facets;

/// The greatest error of interpolated weights, as a part of the light.
pub const WEIGHT_ERROR: f64 = 1e-3;

/// A corner of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetCorner {
    /// Where in the output, pixels from the top left; may be outside of it.
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
    /// They fill the rectangles that they are drawn in place of. Otherwise the output is made black before.
    pub fills: bool,
    /// The greatest error that was measured between corners, pixels of the output.
    pub error: f64,
}

impl Facets {
    /// The triangles for rectangles of an output all of whose pixels' centres show something: as large as a greatest
    /// error in pixels allows. It is measured in the middle of each, of their sides, and between; where what is shown
    /// leaps, triangles are as small as pixels, and exact at their centres.
    pub(in crate::correct) fn within(shown: &Shown, rects: &[PixelRect], max_error: f64) -> Self {
        adaptive::Builder::new(shown, max_error).build(rects)
    }

    /// Some weight is not 1.
    pub fn is_weighted(&self) -> bool {
        self.corners.iter().any(|corner| corner.weight != 1.0)
    }

    fn push(&mut self, place: DVec2, sight: Sight) -> u32 {
        self.corners.push(FacetCorner { place, direction: sight.vector, weight: sight.weight });
        self.corners.len() as u32 - 1
    }
}
