//! System calls that the standard library does not offer, as safe functions.

mod build_id;
mod clock;
mod file;
pub mod process;

pub use build_id::build_id;
pub use clock::thread_time;
pub use file::create;
pub use process::{is_privileged, variable};
