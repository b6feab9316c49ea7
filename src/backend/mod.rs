//! The APIs that run a plan.

pub mod gl;
