//! OpenGL and OpenGL ES.

pub mod accumulation;
pub mod api;
pub mod glx;
pub mod headless;
mod hidden;
mod map;
mod passes;
mod program;
mod state;
pub mod surface;
pub mod trial;

pub use crate::correct::map::MapPixel;
pub use map::gpu_map;
pub use passes::{Blank, GlBackend, Target};

#[cfg(test)]
mod tests;
