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
use crate::intercept::gl::state::shader::program_pipelines::{Pipelines, Stages};
use crate::intercept::gl::state::shader::programs::Program;
use std::sync::Arc;

/// Shaders that a context draws with.
#[derive(Default)]
pub struct Shaders {
    /// The program object that draws: the one in use, or a pipeline's.
    program: Option<Arc<Program>>,
    /// Program pipelines, and which program is in use.
    pipelines: Pipelines,
    /// The vertex program in assembly language of the present draw, if Cupola changed it.
    assembly: Option<Arc<AssemblyProgram>>,
}

impl Shaders {
    /// The program object that draws: the one in use, or a pipeline's.
    pub fn program(&self) -> Option<&Arc<Program>> {
        self.program.as_ref()
    }

    /// Chooses the program object that draws. Returns the one before.
    pub fn choose(&mut self, program: Option<Arc<Program>>) -> Option<Arc<Program>> {
        std::mem::replace(&mut self.program, program)
    }

    /// Notes that a program was linked again, in case it is the one that draws.
    pub fn note_relinked(&mut self, record: Arc<Program>) {
        if let Some(program) = self.program.as_mut().filter(|program| program.name == record.name) {
            *program = record;
        }
    }

    /// Name of the program of `glUseProgram`, which takes precedence over any pipeline; 0 = none.
    pub fn used(&self) -> u32 {
        self.pipelines.used
    }

    /// `glUseProgram`.
    pub fn use_program(&mut self, name: u32) {
        self.pipelines.used = name;
    }

    /// Notes that a program of Cupola stands in for the fixed-function pipeline.
    pub fn use_stand_in(&mut self, program: Arc<Program>) {
        self.pipelines.used = program.name;
        self.program = Some(program);
    }

    /// Notes that the fixed-function pipeline draws again.
    pub fn end_stand_in(&mut self) {
        self.pipelines.used = 0;
        self.program = None;
    }

    /// The bound pipeline; 0 = none.
    pub fn bound_pipeline(&self) -> u32 {
        self.pipelines.bound
    }

    /// `glBindProgramPipeline`.
    pub fn bind_pipeline(&mut self, pipeline: u32) {
        self.pipelines.bound = pipeline;
    }

    /// `glUseProgramStages` with a program that has the stages `present`.
    pub fn set_stages(&mut self, pipeline: u32, stages: u32, program: u32, present: u32) {
        self.pipelines.of(pipeline).set(stages, program, present);
    }

    /// `glActiveShaderProgram`.
    pub fn set_active(&mut self, pipeline: u32, program: u32) {
        self.pipelines.of(pipeline).active = program;
    }

    /// `glDeleteProgramPipelines` of one pipeline.
    pub fn delete_pipeline(&mut self, pipeline: u32) {
        self.pipelines.delete(pipeline);
    }

    /// Returns the programs of the bound pipeline.
    pub fn stages(&self) -> Stages {
        self.pipelines.stages()
    }

    /// The vertex program in assembly language of the present draw, if Cupola changed it.
    pub fn assembly(&self) -> Option<&Arc<AssemblyProgram>> {
        self.assembly.as_ref()
    }

    /// Notes the vertex program in assembly language of the draw that begins.
    pub fn use_assembly(&mut self, program: Option<Arc<AssemblyProgram>>) {
        self.assembly = program;
    }

    /// Notes the end of a draw.
    pub fn end_draw(&mut self) {
        self.assembly = None;
    }
}
