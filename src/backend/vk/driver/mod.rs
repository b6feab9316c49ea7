//! The device: its functions, formats and timers, and a device without a program.

pub mod api;
pub mod formats;
pub mod headless;
pub mod timers;
