//! State of the methods `vertex` and `primitive`.
//!
//! [`fixed_pipeline`] holds the switches of the fixed-function vertex stage, [`fixed_function`] the
//! programs that stand in for it.

pub mod fixed_function;
pub mod fixed_pipeline;

use crate::intercept::gl::state::projected_vertices::fixed_function::FixedFunction;
use crate::intercept::gl::state::shader::division_counter::Counter;

/// State of the methods `vertex` and `primitive`.
#[derive(Default)]
pub struct ProjectedVertices {
    /// True if vertices of the program cannot be projected straight to an output. Windows then have
    /// views.
    pub(in crate::intercept::gl) views_only: bool,
    /// Stand-in for the fixed-function pipeline.
    pub(in crate::intercept::gl) fixed_function: FixedFunction,
    /// Counter of primitives that were not divided far enough.
    pub(in crate::intercept::gl) coarse: Option<Counter>,
    /// True if primitives were divided by stages that cannot count.
    pub(in crate::intercept::gl) uncounted: bool,
}
