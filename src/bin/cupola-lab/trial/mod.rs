//! Corrections timed against each other on contexts and devices of their own.

pub mod gl;
pub mod vk;

#[cfg(test)]
mod tests;
