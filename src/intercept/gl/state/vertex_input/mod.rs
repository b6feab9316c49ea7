//! Places of vertices, indices and uniform blocks.
//!
//! [`buffers`] tells which buffers hold what they held before, [`buffer_bindings`] and
//! [`vertex_arrays`] what is bound, [`vertex_ranges`] where draws from buffers are.

pub mod buffer_bindings;
pub mod buffers;
pub mod vertex_arrays;
pub mod vertex_ranges;

use crate::intercept::gl::state::vertex_input::buffer_bindings::Bound;
use crate::intercept::gl::state::vertex_input::vertex_arrays::VertexArrays;
use crate::intercept::gl::state::vertex_input::vertex_ranges::Ranges;
use std::collections::HashSet;

/// Buffers and vertex arrays that the draws of a context read.
#[derive(Default)]
pub struct VertexInput {
    /// Vertex arrays.
    pub(in crate::intercept::gl) vertex_arrays: VertexArrays,
    pub(in crate::intercept::gl) buffer_bindings: Bound,
    /// Boxes around the draws from buffers.
    pub(in crate::intercept::gl) ranges: Ranges,
    /// Buffers that hold uniform blocks.
    pub(in crate::intercept::gl) blocks: BlockBuffers,
}

/// Buffers that were bound for uniform blocks and storage blocks.
#[derive(Default)]
pub struct BlockBuffers {
    names: HashSet<u32>,
    /// Buffers were bound for storage blocks.
    storage: bool,
    generation: u64,
}

impl BlockBuffers {
    /// A buffer was bound for uniform blocks, or for storage blocks; 0 = none.
    pub fn bound(&mut self, buffer: u32, storage: bool) {
        self.generation += 1;
        self.storage |= storage;
        self.names.insert(buffer);
    }

    /// The content of a buffer changed. Where it may be a uniform block its matrices are read back,
    /// which is a wait for the driver; a program that streams vertices must not have it.
    pub fn changed(&mut self, buffer: u32) {
        self.generation += u64::from(self.names.contains(&buffer));
    }

    /// A buffer of a storage block may have changed, as shaders may write there.
    pub fn storage_changed(&mut self) {
        self.generation += u64::from(self.storage);
    }

    /// Grows with every change of a buffer that may hold uniform blocks.
    pub fn generation(&self) -> u64 {
        self.generation
    }
}
