//! The part between an unmodified program and its driver. It decides which calls to change, and for
//! which views.
//!
//! Interception fails open: if anything goes wrong, the program keeps running with its own picture,
//! and the log gives the reason once.
//!
//! ```text
//! gl, vk       hooks of the two APIs
//! inspection   what is written about a frame
//! scene        decisions about a frame that are the same for both APIs
//! process      what the process around the program has: settings, log, clock, nodes, end
//! ```

pub mod gl;
pub mod inspection;
pub mod process;
pub mod scene;
pub mod vk;
