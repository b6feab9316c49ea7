//! The part between an unmodified program and its driver. It decides which calls to change, and for
//! which views.
//!
//! Interception fails open: if anything goes wrong, the program keeps running with its own picture,
//! and the log gives the reason once.

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
