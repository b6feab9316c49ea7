//! TODO-NOTE

pub mod introspection;
pub mod patch;
pub mod program_pipelines;
pub mod programs;
pub mod samplers;
pub mod uniforms;
