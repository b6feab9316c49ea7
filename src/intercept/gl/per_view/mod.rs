//! TODO-NOTE

pub mod background;
pub mod classify;
pub mod culling;
pub mod issue;
pub mod panel;
pub mod wide_primitives;
pub mod window_space;
