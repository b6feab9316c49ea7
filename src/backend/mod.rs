//! The APIs that run a plan.

pub mod gl;
#[cfg(any(test, fuzzing))]
pub mod null;
#[cfg(test)]
mod tests;
pub mod vk;
