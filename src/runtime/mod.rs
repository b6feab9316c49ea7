//! State of one window: its rig and plan ([`session`]), captures and statistics ([`run_results`],
//! [`frame_times`]), and the view that a frame draws ([`turns`]). [`cache`] opens the process's
//! result cache; [`embedded`] is for the C interface.

pub mod cache;
pub mod embedded;
pub mod frame_times;
pub mod run_results;
pub mod session;
pub mod turns;

pub use session::Session;
