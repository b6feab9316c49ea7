//! From rig and views to passes, independent of the graphics API.

pub mod plan;
pub mod shaders;
pub mod uniforms;

pub use plan::{Batch, OutputPass, PixelRect, Plan};
