//! State of scenes that are drawn off screen.
//!
//! [`framebuffers`] and [`images`] record those of the program, [`view_copies`] holds both and
//! their copies. [`issued`] counts draws, [`coverage`] finds flat draws that show a scene.
//! [`displayed`] and [`single_sample`] are internal pictures, [`depth_converter`] copies depth to
//! other formats.

pub mod coverage;
pub mod depth_converter;
pub mod displayed;
pub mod framebuffers;
pub mod images;
pub mod issued;
pub mod single_sample;
pub mod view_copies;
