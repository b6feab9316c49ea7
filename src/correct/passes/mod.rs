//! TODO-NOTE

pub mod black;
pub mod facets;
pub mod mask;
pub mod optics;
pub mod output_pass;
pub mod rectangle;
pub mod source;
pub mod table;
pub mod tolerance;
pub mod view_images;
