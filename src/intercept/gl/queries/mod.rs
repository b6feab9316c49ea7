//! TODO-NOTE

pub mod conditional_render;
pub mod results;
pub mod scaling;
