//! State that the program sets and asks for.
//!
//! Answers `glViewport`, `glScissor`, `glEnable`, `glPushAttrib` and their relatives
//! ([`window_state`], [`indexed_viewports`]), calls that set followed state ([`known_state`]) and
//! `glGet…` ([`getters`], [`wide_projection`]). While the window is drawn the driver has the
//! viewport of a view. The program reads the viewport that it has set (`Context::app`).

pub mod getters;
pub mod indexed_viewports;
pub mod known_state;
pub mod summed_state;
pub mod wide_projection;
pub mod window_state;
