//! State of scenes that are drawn off screen.
//!
//! [`framebuffers`] and [`images`] record those of the program (`examine` asks the driver),
//! [`view_copies`] holds both and their copies, whose tiles [`tile_grid`] places. [`issued`] counts
//! draws, [`coverage`] finds flat draws that show a scene. [`displayed`] and [`single_sample`] are
//! internal pictures, [`depth_converter`] copies depth to other formats.

pub mod coverage;
pub mod depth_converter;
pub mod displayed;
mod examine;
pub mod framebuffers;
pub mod images;
pub mod issued;
pub mod single_sample;
pub mod tile_grid;
pub mod view_copies;
