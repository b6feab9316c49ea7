//! Queries: the results of occlusion and statistics queries of the program.
//!
//! A draw is issued once per view, so that queries count too much. Their results are multiplied by
//! factors (`scene::query_scaling`), on the host in [`results`] or by a compute shader in
//! [`copies`]. [`running`] finds the factors when a command buffer is submitted. Times and counts
//! of compute shaders are not changed. State: `state::queries`.

pub mod copies;
pub mod hooks;
pub mod results;
pub mod running;
