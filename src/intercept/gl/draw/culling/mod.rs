//! TODO-NOTE

pub mod arrays;
pub mod bounds;
pub mod cleared_views;
pub mod max_width;
pub mod position;
pub mod position_layout;
pub mod prover;
pub mod ranges;
pub mod select;
