//! From rig and views to passes, independent of the graphics API.
//!
//! `passes` holds the types. `sources` finds how an output's pixels become directions. `plan`
//! builds the passes. `shaders` turns them into constants, programs and draws. `projected` serves
//! programs whose vertices are projected to outputs. `over` and `rough` make passes for a rig that is
//! being edited, over the views of the plan before. Each folder uses only folders before it.
//! `single` is the only place where f64 becomes f32.

pub mod over;
pub mod passes;
pub mod plan;
pub mod projected;
pub mod rough;
pub mod shaders;
pub mod single;
pub mod sources;
#[cfg(test)]
mod tests;

pub use crate::correct::passes::black::BlackPicture;
pub use crate::correct::passes::facets::{FacetCorner, Facets};
pub use crate::correct::passes::mask::Mask;
pub use crate::correct::passes::optics::{Light, OpticsSource};
pub use crate::correct::passes::output_pass::{Approximation, Batch, OutputPass, Plan};
pub use crate::correct::passes::source::{EvaluationMethod, Neighbour, ProjectorSource, Source};
pub use crate::correct::passes::table::{Table, TablePixel};
pub use crate::correct::passes::view_images::{Arrangement, ImageSize};
pub use crate::correct::plan::builder::{build, build_with};
pub use crate::correct::plan::footprints::{Footprints, TexelSpan, footprints};
pub use crate::correct::plan::unsampled::unsampled_areas;
pub use crate::correct::plan::unsampled_cached::cached_unsampled_areas;
pub use crate::geom::rectangle::{BlitRect, LowerLeftRect, PixelRect, PixelSpan, Size, UpperLeftRect, apart};
pub use crate::geom::reprojection::Intrinsics;

pub use crate::views::Tile;
