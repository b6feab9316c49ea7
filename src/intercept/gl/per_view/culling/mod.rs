//! TODO-NOTE

pub mod bounds;
pub mod cleared_views;
pub mod max_width;
pub mod position;
pub mod select;
