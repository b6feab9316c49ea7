//! OpenGL and OpenGL ES.

pub mod api;
