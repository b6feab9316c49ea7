//! OpenGL and OpenGL ES.

pub mod accumulation;
pub mod api;
mod binaries;
mod blank;
pub mod glx;
pub mod headless;
mod hidden;
mod known_state;
mod map;
mod passes;
mod program;
mod state;
pub mod surface;
mod textures;
mod whole;

pub use crate::correct::shaders::map::MapPixel;
pub use blank::Blank;
pub use known_state::KnownState;
pub use map::gpu_map;
pub use passes::{GlBackend, Target};

#[cfg(test)]
mod tests;
