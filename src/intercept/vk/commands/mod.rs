//! The commands that the program records into command buffers.
//!
//! Answers commands that bind state, begin and end passes, draw, clear, copy and set conditions,
//! and the calls that make command buffers, render passes and framebuffers. Each command buffer has
//! a `Recording` (`state::recording`). This module changes it while commands are recorded, and
//! `submit` reads it when they are submitted.
//!
//! ```text
//! passes ─── atlas in place of the framebuffer
//! draws ──── one draw per view
//! dispatches: one per view where compute shaders make pictures of the scene
//! unsupported: commands that cannot be followed; the program is shown flat
//! ```

pub mod barriers_and_clears;
pub mod bound_state;
pub mod buffer_copies;
pub mod conditional_render;
pub mod copies;
pub mod dispatches;
pub mod draws;
pub mod passes;
pub mod recording;
pub mod unsupported;
