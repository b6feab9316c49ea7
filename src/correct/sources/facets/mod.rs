//! Triangles over an output. Each corner has a direction and a weight.
//!
//! Between the corners of a triangle, direction and weight are linear over the output. Shaders only
//! compute the view and its texel. The error falls with the square of the triangles' size.

mod adaptive;
mod clip;
mod dome;
pub(in crate::correct) mod lit_parts;

use crate::correct::passes::facets::{FacetCorner, Facets};
use crate::correct::sources::surface_sample::SurfaceSample;
use glam::DVec2;

pub(in crate::correct) use dome::dome_facets;

/// The greatest error of interpolated weights, as a part of the light.
pub const WEIGHT_ERROR: f64 = 1e-3;

impl Facets {
    fn push(&mut self, place: DVec2, sample: SurfaceSample) -> u32 {
        self.corners.push(FacetCorner { place, direction: sample.vector, weight: sample.weight });
        self.corners.len() as u32 - 1
    }
}
