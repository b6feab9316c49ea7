//! State of scenes that are drawn off screen.

pub mod coverage;
pub mod displayed;
pub mod framebuffers;
pub mod images;
pub mod issued;
pub mod single_sample;
pub mod view_copies;
