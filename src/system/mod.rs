//! System calls that the standard library does not offer, and NDI's library, as safe functions.

mod build_id;
mod clock;
mod file;
pub mod ndi;
pub mod process;
mod shared_memory;

pub use build_id::build_id;
pub use clock::{monotonic, thread_time};
pub use file::{anonymous_file, create, free_bytes};
pub use process::{host_name, is_privileged, user, variable};
pub use shared_memory::SharedMemory;
