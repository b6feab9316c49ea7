//! The APIs that run a plan.

pub mod gl;
#[cfg(test)]
mod tests;
pub mod vk;
