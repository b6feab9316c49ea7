//! Passes: where one draws to an image of the window or of the scene, it draws to the atlas in its
//! place.

pub mod dynamic_rendering;
pub mod framebuffers;
pub mod panel_clears;
pub mod render_passes;
