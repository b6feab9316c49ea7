//! TODO-NOTE

pub mod barriers_and_clears;
pub mod bound_state;
pub mod conditional_render;
pub mod copies;
pub mod draws;
pub mod framebuffers;
pub mod indirect;
pub mod panel_clears;
pub mod passes;
pub mod rebind;
pub mod recording;
pub mod replicate;
pub mod tiles;
pub mod unsupported;
