//! OpenGL and OpenGL ES.

pub mod accumulation;
pub mod api;
mod binaries;
mod cleared_views;
mod current_program;
mod errors;
mod full_clear;
pub mod glx;
pub mod headless;
mod known_state;
mod map;
pub mod own_names;
mod passes;
mod program;
mod state;
pub mod surface;
mod target;
mod textures;
mod unsampled_areas;
pub(crate) mod values;

pub use crate::correct::shaders::map::MapPixel;
pub use cleared_views::ClearedViews;
pub use current_program::CurrentProgram;
pub use known_state::KnownState;
pub use map::gpu_map;
pub use passes::GlBackend;
pub use target::Target;

#[cfg(test)]
mod tests;
