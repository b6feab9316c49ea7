//! Finished frames for other processes: a file in shared memory that holds the newest ones.
//!
//! ```text
//! header │ readers: cursor and losses of each │ slot 0 │ slot 1 │ … │ slot n-1
//!                                               a frame: numbers, table of pictures, pixels
//! ```
//!
//! The program is the one [`Writer`]. Frame k lies in slot k modulo n. A [`Reader`] has a cursor,
//! the number of the frame that it wants next. Before the writer uses a slot again, it moves the
//! cursors that point to the slot's old frame on, and counts the frame as lost for these readers;
//! or it waits until they have moved on by themselves, if that was asked for. A reader moves its
//! cursor on when it has copied a frame; if the writer moved it first, the copy does not count. So
//! both sides count the same losses, and no copy is of two frames. A reader counts by its cursor
//! alone, for its place may be that of one that died.
//!
//! Reader and writer hold a lock on a byte of the file while they live. The system gives it back
//! however they end. [`layout`] says where everything lies.

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

pub use place::{default_path, remove_if_ended};
pub use reader::{Frame, Next, Picture, Reader};
pub use writer::{Pictures, Shape, Writer};
