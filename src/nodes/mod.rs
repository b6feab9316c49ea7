//! Programs on several machines that show the same frame at the same time: the page that a program
//! shares with the command `cupola node` on its machine.
//!
//! Both map a [page] in shared memory. At the end of each frame the program writes there that it
//! has [arrived](Gate), and waits until its command [releases it](Page::release). The commands of
//! all nodes agree on the time of release. The program itself does not use the network.

pub mod gate;
pub mod page;

#[cfg(test)]
mod tests;

pub use gate::{FIRST_FRAMES, Gate, Passed, Said};
pub use page::{Arrival, Page};
