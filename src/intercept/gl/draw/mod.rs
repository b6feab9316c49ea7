//! TODO-NOTE

pub mod anisotropy;
pub mod background;
pub mod conditional_render;
pub mod culling;
pub mod issue;
pub mod transform_feedback;
pub mod wide_primitives;
