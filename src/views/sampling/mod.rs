//! TODO-NOTE

pub mod cone;
pub mod output_map;
pub mod samples;
