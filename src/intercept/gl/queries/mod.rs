//! TODO-NOTE

pub mod results;
pub mod scaling;
