//! From rig and views to passes, independent of the graphics API.

pub mod plan;
pub mod projected;
pub mod shaders;
pub mod sources;
#[cfg(test)]
mod tests;

pub use crate::correct::plan::arrangement::{Arrangement, ImageSize};
pub use crate::correct::plan::builder::{Approximation, Batch, OutputPass, PixelRect, Plan, Source, build, build_with};
pub use crate::correct::plan::footprints::{Footprints, Texels, footprints};
pub use crate::correct::plan::unsampled::{hidden_areas, kept_hidden_areas};
pub use crate::correct::sources::facets::{FacetCorner, Facets};
pub use crate::correct::sources::table::{Table, TablePixel};

pub use crate::views::Tile;
