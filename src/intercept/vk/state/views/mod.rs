//! Positions, images and constants of the views.
//!
//! [`atlas_layout`] contains the position of each view in the atlas, [`image_layout`] and
//! [`even_layout`] those for off-screen images. A [`view_target`] is an image
//! that is drawn for each view, with its atlas. [`view_constants`] is the memory that the shaders
//! read for each view. [`vertices`] describes how the shaders process vertices.
//! [`division_counter`] counts the primitives that they did not divide enough.

pub mod atlas_layout;
pub mod division_counter;
pub mod even_layout;
pub mod image_layout;
pub mod vertices;
pub mod view_constants;
pub mod view_target;
