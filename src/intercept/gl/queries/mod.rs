//! Occlusion, statistics and timer queries.
//!
//! Each draw is issued once per view, so what a query counts is scaled ([`scaling`]); [`results`]
//! answers the program with the sums. [`conditional_render`] follows `glBeginConditionalRender`.
//! The factors themselves are those of `intercept::scene::query_scaling`.

pub mod conditional_render;
pub mod results;
pub mod scaling;
