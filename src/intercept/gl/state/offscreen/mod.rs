//! TODO-NOTE

pub mod copies;
pub mod coverage;
pub mod displayed;
pub mod framebuffers;
pub mod images;
pub mod issued;
pub mod single_sample;
