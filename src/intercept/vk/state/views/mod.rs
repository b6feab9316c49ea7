//! Places, images and constants of the views.
//!
//! [`atlas_layout`] says where each view lies in the atlas. A [`view_target`] is an image that is
//! drawn for each view, with its atlas. [`view_constants`] is the memory that the shaders read for
//! each view; [`vertices`] says what the shaders do with vertices, and [`division_counter`] counts
//! the primitives that they did not divide enough.

pub mod atlas_layout;
pub mod division_counter;
pub mod even_layout;
pub mod vertices;
pub mod view_constants;
pub mod view_target;
