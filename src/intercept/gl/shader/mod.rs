//! The program's shaders.
//!
//! Answers compiling and linking ([`programs`], [`linking`]), pipelines ([`program_pipelines`]),
//! matrices ([`uniforms`], [`uniform_commands`], [`attribute_matrices`]) and questions about
//! programs ([`introspection`]). [`source`] reads the texts of shaders and changes them,
//! [`assembly`] those of ARB programs. [`camera_matrices`] lets shaders choose between the
//! program's matrices of its camera and those of a view. [`position`] finds what the text proves in
//! the linked program.

pub mod assembly;
pub mod attribute_matrices;
pub mod camera_matrices;
pub mod introspection;
pub mod linking;
pub mod position;
pub mod program_pipelines;
pub mod program_use;
pub mod programs;
pub mod samplers;
pub mod source;
pub mod summed_uniforms;
pub mod uniform_commands;
pub mod uniforms;
