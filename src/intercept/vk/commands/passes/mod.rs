//! Passes. A pass that draws to an image of the window or of the scene draws to its atlas instead.

pub mod dynamic_rendering;
pub mod framebuffers;
pub mod panel_clears;
pub mod render_passes;
