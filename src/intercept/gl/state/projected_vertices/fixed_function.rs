//! State of what stands in for the fixed-function pipeline.

use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::gl::state::projected_vertices::fixed_pipeline::Pipeline;
use crate::intercept::gl::state::shader::programs::Program;
use crate::runtime::session::Division;
use std::collections::HashMap;
use std::sync::Arc;

/// Task of the processor for the draw that is being issued.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Processor {
    /// Nothing.
    #[default]
    Nothing,
    /// It divides primitives where a view needs that.
    Divides,
    /// It should, but cannot: why, for the log.
    Cannot(&'static str),
}

/// Programs that stand in for the pipeline in a context.
#[derive(Default)]
pub struct FixedFunction {
    /// Task of the processor for the draw that is being issued.
    pub processor: Processor,
    /// Division by the processor for the view that is drawn now, and the rows that lead to that
    /// view.
    pub view: Option<(Division, ReprojectionMatrix)>,
    /// Primitives that the processor did not divide far enough.
    pub coarse: u64,
    /// The switches, or why they cannot be followed; none where they may have changed.
    pub(in crate::intercept::gl) known: Option<Result<Pipeline, &'static str>>,
    pub(in crate::intercept::gl) programs: HashMap<Pipeline, Arc<Program>>,
    /// Switches that were turned on for the program that is in use now.
    pub(in crate::intercept::gl) in_use: Option<Vec<u32>>,
}

impl FixedFunction {
    /// The switches may have changed.
    pub fn touch(&mut self) {
        self.known = None;
    }
}
