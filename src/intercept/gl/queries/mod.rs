//! Occlusion, statistics and timer queries.
//!
//! Each draw is issued once per view, so the counts of queries are scaled ([`scaling`]).
//! [`results`] gives the sums to the program. [`conditional_render`] follows
//! `glBeginConditionalRender`. The factors are computed in `intercept::scene::query_scaling`.

pub mod conditional_render;
pub mod results;
pub mod scaling;
