//! Shaders of the program: where their matrices are, and the epilogue that re-projects what they draw.

mod divide;
mod functions;
mod handed;
mod module;
mod reflect;
mod splice;

pub use divide::{ENTRY, Limits, divide};
pub use handed::handed;
pub use reflect::{Matrix, Memory, asks_place, matrices};
pub use splice::splice;

#[cfg(test)]
mod tests;
