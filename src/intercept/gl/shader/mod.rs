//! The program's shaders.
//!
//! Answers compiling and linking ([`programs`], [`linking`]), pipelines ([`program_pipelines`]), matrices
//! ([`uniforms`], [`uniform_commands`], [`attribute_matrices`]) and questions about programs ([`introspection`]). The
//! last stage before rasterisation gets an epilogue that re-projects `gl_Position` ([`patch`]), fragment shaders get
//! window coordinates of the program ([`frag_coord`]), and both a choice between the program's matrices of its camera and
//! those of a view ([`camera_matrices`]). [`prover`] proves from
//! the text of a vertex shader that positions are an attribute times matrices, and [`position`] finds
//! these in the linked program.

pub mod assembly;
pub mod attribute_matrices;
pub mod camera_matrices;
pub mod compute;
pub mod dependence;
pub mod elements;
pub mod frag_coord;
pub mod head;
pub mod introspection;
pub mod linking;
pub mod patch;
pub mod position;
pub mod program_pipelines;
pub mod program_use;
pub mod programs;
pub mod prover;
pub mod samplers;
pub mod uniform_commands;
pub mod uniforms;
