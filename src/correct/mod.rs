//! From rig and views to passes, independent of the graphics API.

mod arrangement;
mod beam;
pub mod black;
mod blocks;
mod cover;
pub mod division;
pub mod downward;
pub mod draws;
pub mod facets;
mod footprints;
mod hidden;
pub mod map;
pub mod mask;
mod optics;
pub mod plan;
pub mod projection;
mod rectangles;
pub mod response;
mod rounding;
pub mod shaders;
mod shown;
mod source;
pub mod spirv;
pub mod table;
#[cfg(test)]
mod tests;
pub mod uniforms;

pub use arrangement::{Arrangement, ImageSize};
pub use facets::{FacetCorner, Facets};
pub use footprints::{Footprints, Texels, footprints};
pub use hidden::{hidden_areas, kept_hidden_areas};
pub use plan::{Approximation, Batch, OutputPass, PixelRect, Plan, Source, build, build_with};
pub use table::{Table, TablePixel};

pub use crate::views::Tile;

/// For `division`, which the build has, too, with the same file beside it.
use crate::geom::division::rule;
