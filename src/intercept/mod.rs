//! Between an unmodified program and its driver: which calls, which views.
//!
//! Interception fails open: whatever goes wrong, the program keeps running with its own
//! picture, and the log says why, once.

pub mod call_sum;
pub mod camera;
pub mod clock;
pub mod ending;
pub mod file_stamp;
pub mod gl;
pub mod inspection;
pub mod last_frame;
pub mod lens;
pub mod live;
pub mod log;
pub mod nodes;
pub mod publishing;
pub mod scene;
pub mod settings;
pub mod signals;
pub mod vk;
