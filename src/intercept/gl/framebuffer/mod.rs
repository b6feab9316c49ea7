//! TODO-NOTE

pub mod accumulation;
pub mod bindings;
pub mod default_framebuffer;
pub mod direct_state;
pub mod first_read;
pub mod first_read_color;
pub mod first_read_depth;
pub mod own_framebuffer;
pub mod read_back;
pub mod replan;
pub mod textures;
pub mod unsampled_areas;
