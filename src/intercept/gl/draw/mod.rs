//! TODO-NOTE

pub mod anisotropy;
pub mod arrays;
pub mod commands;
pub mod dispatch;
pub mod divided;
pub mod fallback;
pub mod transform_feedback;
