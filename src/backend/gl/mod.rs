//! OpenGL and OpenGL ES.

pub mod api;
mod cover;
pub mod glx;
pub mod headless;
mod map;
mod passes;
mod program;
mod state;
pub mod surface;

pub use map::{MapPixel, gpu_map};
pub use passes::{GlBackend, Target};

#[cfg(test)]
mod tests;
