//! TODO-NOTE

pub mod copies;
pub mod results;
pub mod running;
pub mod scaling;
