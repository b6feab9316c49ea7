//! Between an unmodified program and its driver: which calls, which views.
//!
//! Interception fails open: whatever goes wrong, the program keeps running with its own
//! picture, and the log says why, once.

pub mod camera;
pub mod gl;
pub mod kept;
pub mod lens;
pub mod live;
pub mod log;
pub mod obstacle;
pub mod scene;
pub mod settings;
pub mod vk;
