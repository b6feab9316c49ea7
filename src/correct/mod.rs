//! From rig and views to passes, independent of the graphics API.

pub mod plan;

pub use plan::{Batch, OutputPass, PixelRect, Plan};
