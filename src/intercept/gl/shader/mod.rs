//! The program's shaders.
//!
//! Hooks of compiling and linking are in [`linking`], those of using programs in [`program_use`]
//! and [`program_pipelines`], those of matrices in [`uniform_commands`], those of questions about
//! programs in [`introspection`]. [`programs`], [`uniforms`] and [`attribute_matrices`] find the
//! lens. [`source`] reads the texts of shaders and changes them, [`assembly`] those of ARB
//! programs. [`camera_matrices`] lets shaders choose between the program's matrices of its camera
//! and those of a view. [`position`] finds in the linked program what the text proves,
//! [`changed`] the buffers and images that its draws write.

pub mod assembly;
pub mod attribute_matrices;
pub mod camera_matrices;
pub mod changed;
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
