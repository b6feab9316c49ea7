//! Reads of the program from its window.
//!
//! [`read_back`] moves a read to the tile that holds the program's own picture. Before the first
//! read there is no such tile: [`first_read`] fills it from the views, with [`first_read_color`]
//! and [`first_read_depth`]. [`resolve`] resolves the samples of the part that is read.

pub mod first_read;
pub mod first_read_color;
pub mod first_read_depth;
pub mod read_back;
pub mod resolve;
