//! Draws: each becomes a draw per view, one on the panel and one in the primary view.
//!
//! ```text
//! hooks ─ replicate ─ tiles ─ rebind
//!         indirect: parameters in memory, so that a draw that shows nothing can be left out
//! ```

pub mod hooks;
pub mod indirect;
pub mod parts;
pub mod rebind;
pub mod replicate;
pub mod tiles;
