//! System calls that the standard library does not offer, as safe functions.

mod build_id;
pub mod process;

pub use build_id::build_id;
