//! One window's Cupola: rig and plan, what a frame looked like, and what was counted.

pub mod cache;
pub mod embedded;
pub mod report;
pub mod session;

pub use session::Session;
