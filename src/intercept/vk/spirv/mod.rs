//! Shaders of the program: the locations of their matrices, the epilogue that reprojects vertices,
//! and the position of fragments in the program's window.

mod camera_matrices;
mod compute;
mod dependence;
mod divide;
mod frag_coord;
mod functions;
mod module;
mod reflect;
mod splice;
mod stage_outputs;
mod texels;

pub use camera_matrices::{CAMERA_BYTES, Chosen, MOST_CAMERAS, camera_matrices};
pub use compute::{BufferWrites, ComputeUse, compute_use};
pub use divide::{ENTRY, Limits, divide};
pub use frag_coord::frag_coord;
pub use reflect::{Matrix, Memory, asks_place, matrices};
pub use splice::splice;
pub use stage_outputs::stage_outputs;
pub use texels::{DescriptorPlace, Followed, MOST_PICTURES, texels};

#[cfg(test)]
mod tests;
