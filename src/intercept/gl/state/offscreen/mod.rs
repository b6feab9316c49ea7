//! State of scenes that are drawn off screen.
//!
//! [`framebuffers`] and [`images`] are the program's, [`view_copies`] holds both and what stands
//! for them. [`issued`] counts draws, [`coverage`] tells flat draws that show a scene,
//! [`displayed`] and [`single_sample`] are pictures of our own, [`depth_converter`] copies depth to
//! other formats.

pub mod coverage;
pub mod depth_converter;
pub mod displayed;
pub mod framebuffers;
pub mod images;
pub mod issued;
pub mod single_sample;
pub mod view_copies;
