//! Places of vertices, indices and uniform blocks.
//!
//! [`buffers`] follows changes of buffers, [`buffer_bindings`] and [`vertex_arrays`] follow
//! bindings, [`vertex_ranges`] holds boxes around the vertices of draws from buffers.

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

impl VertexInput {
    /// Returns a number that grows with every change of a buffer that may hold uniform blocks.
    pub fn generation(&self) -> u64 {
        self.blocks.generation()
    }

    /// Notes that a buffer of a storage block may have changed, as shaders may write to it.
    pub fn storage_changed(&mut self) {
        self.blocks.storage_changed();
    }

    /// Number of ranges of vertices that were read so far.
    pub fn ranges_read(&self) -> u64 {
        self.ranges.reads
    }
}

/// Buffers that were bound for uniform blocks and storage blocks.
#[derive(Default)]
pub struct BlockBuffers {
    names: HashSet<u32>,
    /// True if buffers were bound for storage blocks.
    storage: bool,
    generation: u64,
}

impl BlockBuffers {
    /// Notes that a buffer was bound for uniform blocks, or for storage blocks; 0 = none.
    pub fn bound(&mut self, buffer: u32, storage: bool) {
        self.generation += 1;
        self.storage |= storage;
        self.names.insert(buffer);
    }

    /// Notes that the content of a buffer changed. If the buffer may hold a uniform block, its
    /// matrices are read back later, which waits for the driver. A change of other buffers, such as
    /// streamed vertices, must not cause this wait.
    pub fn changed(&mut self, buffer: u32) {
        self.generation += u64::from(self.names.contains(&buffer));
    }

    /// Notes that a buffer of a storage block may have changed, as shaders may write to it.
    pub fn storage_changed(&mut self) {
        self.generation += u64::from(self.storage);
    }

    /// Returns a number that grows with every change of a buffer that may hold uniform blocks.
    pub fn generation(&self) -> u64 {
        self.generation
    }
}
