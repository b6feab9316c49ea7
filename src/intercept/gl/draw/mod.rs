//! Draw commands of the program, and where they go.
//!
//! Answers `glDraw…` ([`arrays`], [`commands`]); draws of Begin/End and of display lists come from
//! `compat`. [`dispatch`] sends a draw to the window's views, to the flat panel, or off screen.
//! [`fallback`] gives a window views where vertices cannot be projected straight to an output, and
//! [`divided`] issues draws whose primitives the processor divides. Two small files answer calls that
//! touch draws: [`transform_feedback`], [`anisotropy`].

pub mod anisotropy;
pub mod arrays;
pub mod commands;
pub mod dispatch;
pub mod divided;
pub mod fallback;
pub mod transform_feedback;
