//! Stand-in image for framebuffer 0.
//!
//! Hooks of the program's commands on framebuffers are in [`commands`]: bindings, clears, draw
//! buffers, blits. [`reading`] answers the program's reads from its window. [`target`] owns the
//! stand-in image: it makes the atlas, replaces it if window or rig change, and enlarges it for the
//! panel and the program's own picture. `commands` uses `reading` and `target`, `reading` uses
//! `target`.
//!
//! ```text
//! framebuffer 0 of the program = one atlas: view │ view │ … │ panel │ program's own picture
//! ```

pub mod commands;
pub mod reading;
pub mod target;
