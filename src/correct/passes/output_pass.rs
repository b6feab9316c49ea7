//! The passes of a frame: what a backend gets.

use crate::correct::passes::black::BlackPicture;
use crate::correct::passes::facets::Facets;
use crate::correct::passes::mask::Mask;
use crate::correct::passes::source::Source;
use crate::geom::ContentMap;
use crate::geom::rectangle::PixelRect;
use crate::rig::{AngleRamp, Filter, Flip, Transfer};
use crate::views::ViewPlan;
use glam::DMat3;
use std::sync::Arc;

/// Everything a backend needs to correct a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The views and the atlas.
    pub views: ViewPlan,
    /// A pass for each output, in the rig's order.
    pub passes: Vec<OutputPass>,
}

/// Correction of one output. Pixels in no batch are black. Everything except the mask and the
/// picture of black describes the picture before it is mirrored.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputPass {
    /// The output's name.
    pub name: String,
    /// True if this machine shows the output.
    pub here: bool,
    /// The output's resolution in pixels.
    pub size: (u32, u32),
    /// Output pixel (normalised, see [`Batch`]) → ray.
    pub source: Source,
    /// Rectangles that share a shader.
    pub batches: Vec<Batch>,
    /// Weight image at the output's resolution or any other; linear light, 0…1, row 0 at the top;
    /// mirrored as the picture is.
    pub mask: Option<Mask>,
    /// Ramps in dome angles, multiplied in.
    pub ramps: Vec<AngleRamp>,
    /// Viewer axes → dome axes turned so that the pole is +y and the front −z. For ramps in dome
    /// angles of outputs that are not projectors; projectors have their own dome direction.
    pub dome_rotation: DMat3,
    /// Filter of the views; a view with the program's own lens has no guard and is sampled
    /// bilinearly.
    pub filter: Filter,
    /// Exponent of the display's response, for [`Transfer::Power`].
    pub gamma: f64,
    /// Response of the display: encoded values to light.
    pub transfer: Transfer,
    /// Linear light added to black (`out = level + (1 − level)·x`).
    pub black_level: f64,
    /// Displayed value of black for each pixel, in place of the level; mirrored as the picture is.
    pub black: Option<BlackPicture>,
    /// Greatest light of all blacks together at any point, as a part of white. Where a point has
    /// less, each output adds its share of the difference. 0 = nothing is added.
    pub lift: f64,
    /// Step of the display's codes by which values are dithered; 0 = no dithering.
    pub dither: f64,
    /// Mirroring of the picture as it is drawn.
    pub flip: Flip,
    /// Maps a direction to a place in the program's window. The only view is then that window, not
    /// a perspective view.
    pub content: Option<ContentMap>,
}

/// Interpolation of an output's map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Approximation {
    /// Between the entries of a table.
    Table {
        /// Distance between entries, pixels, at least 2.
        step: u32,
        /// Greatest error at a pixel's centre, pixels.
        error: f64,
    },
    /// Between the corners of triangles.
    Triangles {
        /// Number of triangles.
        count: usize,
        /// Greatest error that was measured between corners, pixels.
        error: f64,
    },
}

impl OutputPass {
    /// Returns the rectangles in which every pixel is drawn.
    pub(in crate::correct) fn filled(&self) -> impl Iterator<Item = &PixelRect> {
        let filled = self.batches.iter().filter(|batch| batch.facets.as_ref().is_none_or(|facets| facets.fills));
        filled.flat_map(|batch| &batch.rects)
    }

    /// Returns the part of the output, 0…1, that is black before its batches are drawn, and mostly
    /// stays black.
    pub fn black_part(&self) -> f64 {
        let filled: f64 = self.filled().map(|rect| f64::from(rect.width) * f64::from(rect.height)).sum();
        1.0 - filled / (f64::from(self.size.0) * f64::from(self.size.1)).max(1.0)
    }

    /// Returns the interpolation of the map and its error; `None` where each pixel has its own
    /// direction.
    pub fn approximation(&self) -> Option<Approximation> {
        let facets: Vec<&Facets> = self.batches.iter().filter_map(|batch| batch.facets.as_deref()).collect();
        match &self.source {
            _ if !facets.is_empty() => Some(Approximation::Triangles {
                count: facets.iter().map(|facets| facets.triangles.len()).sum(),
                error: facets.iter().map(|facets| facets.error).fold(0.0, f64::max),
            }),
            Source::Table(table) if table.step() > 1 => {
                Some(Approximation::Table { step: table.step(), error: table.error() })
            }
            _ => None,
        }
    }
}

/// Rectangles of one output that the same specialised shader draws.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Indices of the views that its pixels sample, in order of precedence.
    pub views: Vec<usize>,
    /// Indices into the output's neighbours whose pictures overlap here; empty = no blending from
    /// overlap.
    pub neighbours: Vec<usize>,
    /// True if some pixels show nothing (rim of a circle, off the screen), so that the shader must
    /// test.
    pub edge: bool,
    /// True if the output has a mask that is not white there.
    pub masked: bool,
    /// The rectangles.
    pub rects: Vec<PixelRect>,
    /// Triangles that replace the rectangles. Their corners then give the directions, not the
    /// output's source.
    pub facets: Option<Arc<Facets>>,
}
