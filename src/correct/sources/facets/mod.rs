//! Triangles over an output whose corners know what is seen there.
//!
//! Between the corners of a triangle direction and weight are linear over the output, and shaders
//! have nothing left to compute but the view and its texel. The error falls with the square of the
//! triangles' size.

mod adaptive;
mod clip;
mod dome;
pub(in crate::correct) mod lit_parts;

use crate::correct::passes::facets::{FacetCorner, Facets};
use crate::correct::sources::surface_sample::{SurfaceSample, SurfaceSampler};
use crate::geom::rectangle::PixelRect;
use glam::DVec2;

pub(in crate::correct) use dome::dome_facets;

/// The greatest error of interpolated weights, as a part of the light.
pub const WEIGHT_ERROR: f64 = 1e-3;

impl Facets {
    /// The triangles for rectangles of an output all of whose pixels' centres show something: as
    /// large as a greatest error in pixels allows. It is measured in the middle of each, of their
    /// sides, and between; where the map is discontinuous, triangles are as small as pixels, and
    /// exact at their centres.
    pub(in crate::correct) fn within(sampler: &SurfaceSampler, rects: &[PixelRect], max_error: f64) -> Self {
        adaptive::Builder::new(sampler, max_error).build(rects)
    }

    fn push(&mut self, place: DVec2, sample: SurfaceSample) -> u32 {
        self.corners.push(FacetCorner { place, direction: sample.vector, weight: sample.weight });
        self.corners.len() as u32 - 1
    }
}
