//! TODO-NOTE

pub mod current;
pub mod debug_output;
pub mod errors;
pub mod getters;
pub mod gl_context;
pub mod hooks;
pub mod indexed_viewports;
pub mod known_state;
pub mod statistics;
pub mod window;
pub mod window_state;
