//! The device: its functions, its clock, a device without a program.

pub mod api;
pub mod headless;
pub mod timers;
