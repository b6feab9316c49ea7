//! Programs of the group of contexts, and the program that draws.
//!
//! [`programs`] holds linked programs, [`position_names`] the names that flow into their positions,
//! [`uniforms`] and [`attribute_matrices`] their matrices, [`camera_matrices`] the matrices that
//! fragments compute with. [`program_pipelines`] holds the pipelines, [`assembly`] programs in
//! assembly language. [`variants`] are programs that divide primitives. [`uniform_mirror`] gives
//! them the values of the program's uniforms, [`division_counter`] counts primitives that they do
//! not divide far enough.

pub mod assembly;
pub mod attribute_matrices;
pub mod camera_matrices;
pub mod division_counter;
pub mod position_names;
pub mod program_pipelines;
pub mod programs;
pub mod uniform_mirror;
pub mod uniforms;
pub mod variants;

use crate::intercept::gl::state::shader::assembly::AssemblyProgram;
use crate::intercept::gl::state::shader::program_pipelines::Pipelines;
use crate::intercept::gl::state::shader::programs::Program;
use std::sync::Arc;

/// Shaders that a context draws with.
#[derive(Default)]
pub struct Shaders {
    /// The program object that draws: the one in use, or a pipeline's.
    pub(in crate::intercept::gl) program: Option<Arc<Program>>,
    /// Program pipelines, and which program is in use.
    pub(in crate::intercept::gl) pipelines: Pipelines,
    /// The vertex program in assembly language of the present draw, if Cupola changed it.
    pub(in crate::intercept::gl) assembly: Option<Arc<AssemblyProgram>>,
}
