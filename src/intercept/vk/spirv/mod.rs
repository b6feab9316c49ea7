//! Shaders of the program: the locations of their matrices, the epilogue that reprojects vertices,
//! and the position of fragments in the program's window.
//!
//! `module` reads words, `functions` adds to them. The other modules are used through the
//! exports of this file.

mod addresses;
mod camera_matrices;
mod compute;
mod dependence;
mod frag_coord;
pub(in crate::intercept::vk) mod functions;
pub(in crate::intercept::vk) mod module;
mod reflect;
mod splice;
mod texels;

pub use camera_matrices::{CAMERA_BYTES, Chosen, MOST_CAMERAS, camera_matrices};
pub use compute::{BufferWrites, ComputeUse, compute_use, without_writes};
pub use frag_coord::backdrop::{BACKDROP_VECTORS, backdrop};
pub use frag_coord::frag_coord;
pub use reflect::{Matrix, Memory, asks_place, attribute_matrices, has_fixed_position, matrices, missing_lens};
pub use splice::splice;
pub use texels::{DescriptorPlace, Followed, MOST_PICTURES, texels};

#[cfg(test)]
pub(in crate::intercept::vk) mod tests;
