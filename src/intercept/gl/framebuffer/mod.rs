//! TODO-NOTE

pub mod accumulation;
pub mod bindings;
pub mod config;
pub mod default_framebuffer;
pub mod direct_state;
pub mod first_read_color;
pub mod first_read_depth;
pub mod read_back;
pub mod unsampled_areas;
