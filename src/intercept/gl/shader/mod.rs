//! TODO-NOTE

pub mod introspection;
pub mod patch;
pub mod position;
pub mod program_pipelines;
pub mod programs;
pub mod prover;
pub mod samplers;
pub mod uniforms;
