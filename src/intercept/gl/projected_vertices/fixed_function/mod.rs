//! TODO-NOTE

pub mod arrays;
pub mod assembly;
pub mod division;
pub mod pipeline;
pub mod shader_text;
pub mod substitute;
pub mod vertices;
