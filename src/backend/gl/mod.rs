//! OpenGL and OpenGL ES.
//!
//! ```text
//! driver ◄── state ◄── objects ◄── passes, accumulation, map
//! ```
//!
//! `driver` holds the function table and queries. `state` saves and restores the program's state.
//! `objects` are programs, textures and framebuffers of Cupola. `passes` correct a frame.

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
