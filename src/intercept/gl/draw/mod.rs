//! Draw commands of the program, and their routes.
//!
//! Hooks of `glDraw…` are in [`arrays`] and [`commands`]; draws of Begin/End and of display lists
//! come from `compat`. [`routing`] sends a draw to the window's views, to the flat panel, or off
//! screen. If the methods `vertex` and `primitive` are not possible, [`fallback`] makes the window
//! use views. [`divided`] issues draws whose primitives the processor divides.
//! [`transform_feedback`] follows whether transform feedback records; `per_view::issue` makes sure
//! that a repeated draw is recorded once. [`anisotropy`] adapts a filter to the views.

pub mod anisotropy;
pub mod arrays;
pub mod commands;
pub mod compute;
pub mod divided;
pub mod fallback;
pub mod routing;
pub mod transform_feedback;
