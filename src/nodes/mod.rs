//! Programs on several machines that show the same frame at the same time: what a program and the
//! command `cupola node` beside it tell each other.
//!
//! Both have a [page] in shared memory. At the end of each frame the program writes down that
//! it has [arrived](Gate) there, and waits until its command [lets it go](Page::release). The
//! commands of all nodes agree among themselves on when that is; the program knows nothing of a
//! network.

pub mod gate;
pub mod page;

#[cfg(test)]
mod tests;

pub use gate::{FIRST_FRAMES, Gate, Passed, Said};
pub use page::{Arrival, Page};
