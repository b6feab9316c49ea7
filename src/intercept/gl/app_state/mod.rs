//! TODO-NOTE

pub mod getters;
pub mod indexed_viewports;
pub mod known_state;
pub mod window_state;
