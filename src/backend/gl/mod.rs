//! OpenGL and OpenGL ES.
//!
//! ```text
//! driver ◄── state ◄── objects ◄── passes, accumulation, map
//! ```
//!
//! `driver` is the function table with what answers questions, `state` what is put back, `objects`
//! are programs, textures and framebuffers of Cupola, `passes` the correction of a frame.

pub mod accumulation;
pub mod driver;
mod map;
pub mod objects;
mod passes;
mod state;

pub use crate::correct::shaders::map::MapPixel;
pub use map::gpu_map;
pub use objects::own_framebuffer::OwnFramebuffer;
pub use objects::target::Target;
pub use passes::{ClearedViews, GlBackend, Spread};
pub use state::current_program::CurrentProgram;
pub use state::known_state::KnownState;

#[cfg(test)]
mod tests;
