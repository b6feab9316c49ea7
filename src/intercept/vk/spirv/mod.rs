//! Shaders of the program: where their matrices are, and the epilogue that re-projects what they
//! draw.

mod dependence;
mod divide;
mod functions;
mod module;
mod reflect;
mod splice;
mod stage_outputs;

pub use divide::{ENTRY, Limits, divide};
pub use reflect::{Matrix, Memory, asks_place, matrices};
pub use splice::splice;
pub use stage_outputs::stage_outputs;

#[cfg(test)]
mod tests;
