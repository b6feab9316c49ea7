//! Queries: what the program reads of occlusion and statistics queries.
//!
//! A draw is issued once per view, so that queries count too much. Their results are multiplied by
//! factors (`scene::query_scaling`), by the host in [`results`] or by a compute shader in
//! [`copies`]. [`running`] finds the factors when a command buffer is submitted. Times and counts
//! of compute shaders stay as they are. State: `state::queries`.

pub mod copies;
pub mod hooks;
pub mod results;
pub mod running;
