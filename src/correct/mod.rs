//! From rig and views to passes, independent of the graphics API.

pub mod passes;
pub mod plan;
pub mod projected;
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
pub use crate::correct::passes::rectangle::PixelRect;
pub use crate::correct::passes::source::{Neighbour, ProjectorSource, Source, Way};
pub use crate::correct::passes::table::{Table, TablePixel};
pub use crate::correct::passes::view_images::{Arrangement, ImageSize};
pub use crate::correct::plan::builder::{build, build_with};
pub use crate::correct::plan::footprints::{Footprints, Texels, footprints};
pub use crate::correct::plan::unsampled::hidden_areas;
pub use crate::correct::plan::unsampled_cached::kept_hidden_areas;

pub use crate::views::Tile;
