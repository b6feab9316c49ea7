//! The APIs that run a plan.

pub mod gl;
#[cfg(test)]
pub mod null;
#[cfg(test)]
mod tests;
pub mod vk;
