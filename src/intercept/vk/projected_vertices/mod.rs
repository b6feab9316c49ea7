//! Methods `vertex` and `primitive`: vertices are projected straight to an output.
//!
//! # Design
//!
//! The epilogue of `spirv::splice` projects vertices. What it reads, the lens constants of an
//! output, follows the reprojection matrix in the view constants (`state::views`). This room adds
//! what the methods need beyond that:
//!
//! * [`decide`] says, when a device is made, how its shaders process vertices. This cannot change
//!   later, since pipelines are made once and a device's features cannot be added. `layer` enables
//!   the features.
//! * [`dividing_stage()`] returns the words of a geometry stage for a pipeline of the program. The
//!   stage divides lines and triangles until straight edges follow the lens, projects the parts,
//!   and counts parts that are not fine enough. `pipelines` makes a variant of the pipeline with
//!   it. If a pipeline cannot have the stage, its vertices alone are projected, and the log and the
//!   statistics give the reason.
//!
//! ```text
//! decision ─ layer (device)
//! dividing_stage ─┬─ stage_outputs (variables between vertex and fragment shader)
//!                 └─ geometry_stage (words of the stage)
//! ```
//!
//! The arithmetic is `correct::projected::division`, the same for both APIs. Other folders use only
//! the exports of this file.

mod decision;
mod dividing_stage;
mod geometry_stage;
mod stage_outputs;
#[cfg(test)]
mod tests;

pub use decision::{NO_STAGE, NO_WAY, decide};
pub use dividing_stage::stage as dividing_stage;
pub use geometry_stage::{ENTRY, Limits, divide};
pub use stage_outputs::stage_outputs;
