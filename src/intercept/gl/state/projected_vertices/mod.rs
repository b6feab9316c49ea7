//! State of the methods `vertex` and `primitive`.
//!
//! [`fixed_pipeline`] holds the switches of the fixed-function vertex stage, [`fixed_function`] the
//! programs that stand in for it.

pub mod fixed_function;
pub mod fixed_pipeline;

use crate::backend::gl::driver::api::Gl;
use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::gl::state::projected_vertices::fixed_function::{FixedFunction, Processor};
use crate::intercept::gl::state::projected_vertices::fixed_pipeline::Pipeline;
use crate::intercept::gl::state::shader::division_counter::Counter;
use crate::intercept::gl::state::shader::programs::Program;
use crate::intercept::scene::obstacle::Obstacle;
use crate::runtime::session::Division;
use std::sync::Arc;

/// State of the methods `vertex` and `primitive`.
#[derive(Default)]
pub struct ProjectedVertices {
    /// True if vertices of the program cannot be projected straight to an output. Windows then have
    /// views.
    views_only: bool,
    /// Stand-in for the fixed-function pipeline.
    fixed_function: FixedFunction,
    /// Counter of primitives that were not divided far enough.
    coarse: Option<Counter>,
    /// True if primitives were divided by stages that cannot count.
    uncounted: bool,
}

impl ProjectedVertices {
    /// True if windows have views, as vertices of the program cannot be projected straight to an
    /// output.
    pub fn views_only(&self) -> bool {
        self.views_only
    }

    /// Windows have views from now on.
    pub fn use_views_only(&mut self) {
        self.views_only = true;
    }

    /// Begins a draw, in which the processor has this task.
    pub fn begin_draw(&mut self, processor: Processor) {
        self.fixed_function.processor = processor;
    }

    /// Ends the draw.
    pub fn end_draw(&mut self) {
        self.fixed_function.processor = Processor::Nothing;
    }

    /// Task of the processor for the draw that is being issued.
    pub fn processor(&self) -> &Processor {
        &self.fixed_function.processor
    }

    /// Notes the division by the processor for the view that is drawn next.
    pub fn divide_view(&mut self, division: Division, reprojection: ReprojectionMatrix) {
        self.fixed_function.view = Some((division, reprojection));
    }

    /// Returns the division by the processor for the view that is drawn now, and the reprojection
    /// matrix of that view. Returns them once.
    pub fn take_view(&mut self) -> Option<(Division, ReprojectionMatrix)> {
        self.fixed_function.view.take()
    }

    /// Counts primitives that the processor did not divide far enough.
    pub fn count_coarse(&mut self, primitives: u64) {
        self.fixed_function.coarse += primitives;
    }

    /// Notes that the switches of the fixed-function pipeline may have changed.
    pub fn note_switch(&mut self) {
        self.fixed_function.known = None;
    }

    /// Notes the switches of the fixed-function pipeline, or the reason why they cannot be
    /// followed.
    pub fn note_pipeline(&mut self, pipeline: Result<Pipeline, Obstacle>) {
        self.fixed_function.known = Some(pipeline);
    }

    /// The switches of the fixed-function pipeline; `None` if they may have changed.
    pub fn pipeline(&self) -> Option<&Result<Pipeline, Obstacle>> {
        self.fixed_function.known.as_ref()
    }

    /// Returns the program that stands in for a pipeline with these switches.
    pub fn stand_in(&self, pipeline: &Pipeline) -> Option<Arc<Program>> {
        self.fixed_function.programs.get(pipeline).cloned()
    }

    /// Stores a program that stands in for a pipeline with these switches.
    pub fn store_stand_in(&mut self, pipeline: Pipeline, program: Arc<Program>) {
        self.fixed_function.programs.insert(pipeline, program);
    }

    /// Notes that a program stands in for the pipeline now, and the switches that were turned on
    /// for it.
    pub fn use_stand_in(&mut self, switched: Vec<u32>) {
        self.fixed_function.in_use = Some(switched);
    }

    /// Notes that the pipeline draws again. Returns the switches that were turned on; `None` if no
    /// program stood in for it.
    pub fn end_stand_in(&mut self) -> Option<Vec<u32>> {
        self.fixed_function.in_use.take()
    }

    /// Counter of primitives that shaders did not divide far enough.
    pub fn counter(&self) -> Option<&Counter> {
        self.coarse.as_ref()
    }

    /// Counts these primitives with a counter of the device.
    pub fn count_with(&mut self, counter: Counter) {
        self.coarse = Some(counter);
    }

    /// Notes whether the stages that divide primitives can count.
    pub fn note_counting(&mut self, possible: bool) {
        self.uncounted |= !possible;
    }

    /// Returns the number of primitives that were not divided far enough; `None` if they could not
    /// be counted.
    pub fn coarse_primitives(&self, gl: &Gl) -> Option<u64> {
        let counted = || self.coarse.as_ref().map_or(0, |counter| counter.read(gl).into());
        (!self.uncounted).then(|| self.fixed_function.coarse + counted())
    }
}
