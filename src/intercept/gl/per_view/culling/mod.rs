//! Draws that are left out of views that cannot show them.

pub mod bounds;
pub mod cleared_views;
pub mod max_width;
pub mod position;
pub mod select;
