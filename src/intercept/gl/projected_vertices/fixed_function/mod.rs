//! The fixed-function pipeline, which a program of Cupola replaces if vertices are projected.

pub mod arrays;
pub mod assembly;
pub mod division;
pub mod pipeline;
pub mod shader_text;
pub mod substitute;
pub mod vertices;
