//! State of the programs that stand in for the fixed-function pipeline.

use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::gl::state::projected_vertices::fixed_pipeline::Pipeline;
use crate::intercept::gl::state::shader::programs::Program;
use crate::intercept::scene::obstacle::Obstacle;
use crate::runtime::session::Division;
use std::collections::HashMap;
use std::sync::Arc;

/// Task of the processor for the draw that is being issued.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Processor {
    /// Nothing.
    #[default]
    Nothing,
    /// The processor divides primitives if a view needs that.
    Divides,
    /// The processor should divide primitives, but cannot, for this reason.
    Cannot(Obstacle),
}

/// Programs that stand in for the pipeline in a context.
#[derive(Default)]
pub(super) struct FixedFunction {
    /// Task of the processor for the draw that is being issued.
    pub(super) processor: Processor,
    /// Division by the processor for the view that is drawn now, and the reprojection matrix of
    /// that view.
    pub(super) view: Option<(Division, ReprojectionMatrix)>,
    /// Number of primitives that the processor did not divide far enough.
    pub(super) coarse: u64,
    /// The switches, or the reason why they cannot be followed; `None` if they may have changed.
    pub(super) known: Option<Result<Pipeline, Obstacle>>,
    pub(super) programs: HashMap<Pipeline, Arc<Program>>,
    /// Switches that were turned on for the program that is in use now.
    pub(super) in_use: Option<Vec<u32>>,
}
