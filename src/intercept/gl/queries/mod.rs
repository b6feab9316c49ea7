//! Occlusion, statistics and timer queries.
//!
//! Each draw is issued once per view, so what a query counts is scaled ([`scaling`]); [`results`]
//! answers the program with the sums. [`conditional_render`] follows `glBeginConditionalRender`. The
//! weights themselves are those of `intercept::scene::query_weights`.

pub mod conditional_render;
pub mod results;
pub mod scaling;
