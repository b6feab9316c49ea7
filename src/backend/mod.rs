//! The APIs that run a plan.

#[cfg(test)]
mod cases;
pub mod gl;
pub mod vk;
