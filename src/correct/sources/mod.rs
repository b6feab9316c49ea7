//! TODO-NOTE

pub mod facets;
pub mod output_source;
pub mod ray_form;
pub mod rounding;
pub mod surface_sample;
pub mod table;
pub mod table_cached;
pub mod table_coarse;
