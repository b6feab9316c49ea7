//! Finished frames for other processes: a file in shared memory that holds the newest ones.
//!
//! ```text
//! header │ readers: cursor and losses of each │ slot 0 │ slot 1 │ … │ slot n-1
//!                                               a frame: numbers, table of pictures, pixels
//! ```
//!
//! The program has the only [`Writer`]. Frame k lies in slot k modulo n. A [`Reader`] has a cursor,
//! the number of the frame that it copies next. Before the writer uses a slot again, it advances
//! the cursors that point to the slot's old frame, and counts the frame as lost for these readers.
//! If so configured, it waits instead until they have advanced by themselves. A reader advances its
//! cursor after copying a frame; if the writer advanced it first, the copy is discarded. So both
//! sides count the same losses, and no copy mixes two frames. A reader counts by its cursor alone,
//! because the words of its entry may be those of a dead reader.
//!
//! Reader and writer hold a lock on a byte of the file while they live. The system releases it
//! however they end. [`layout`] defines the positions.

pub mod layout;
pub mod place;
pub mod reader;
pub mod writer;

#[cfg(test)]
mod c_header;
#[cfg(test)]
mod interleavings;
#[cfg(test)]
mod tests;

pub use layout::{Format, Stamp, text_sum};
pub use place::{default_path, remove_if_ended};
pub use reader::{Frame, Next, Picture, Reader};
pub use writer::{Pictures, Shape, Writer};
