//! TODO-NOTE

pub mod current;
pub mod errors;
pub mod gl_context;
pub mod hooks;
pub mod list_recording;
pub mod matrices;
pub mod methods;
pub mod own_calls;
pub mod read_pixels;
pub mod window_space;
