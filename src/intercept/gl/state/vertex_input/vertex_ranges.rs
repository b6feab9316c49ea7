//! Boxes around ranges of vertices in buffers.

use crate::intercept::gl::state::draw::bounds::Bounds;
use std::collections::HashMap;
use std::ffi::c_void;

/// The vertices of a draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Vertices {
    /// Consecutive vertices.
    Range {
        /// Number of the first vertex.
        first: i32,
        /// Number of vertices.
        count: i32,
    },
    /// Vertices that indices name.
    Elements {
        /// Number of indices.
        count: i32,
        /// Type of the indices.
        kind: u32,
        /// Address of the indices, or their offset in the buffer of indices.
        indices: *const c_void,
        /// Number that is added to each index.
        base: i32,
    },
}

/// Known boxes around ranges of vertices.
#[derive(Default)]
pub struct Ranges {
    pub(in crate::intercept::gl) known: HashMap<Key, Known>,
    /// Frame to which the next values belong. The frames of the group count, since a context
    /// without a window swaps nothing.
    frame: u64,
    /// Number of bytes that were read in this frame.
    spent: usize,
    /// True if there is no room for more ranges in this frame.
    pub(in crate::intercept::gl) full: bool,
    /// Number of ranges that were read so far.
    pub reads: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::intercept::gl) struct Key {
    pub(in crate::intercept::gl) layout: Layout,
    pub(in crate::intercept::gl) vertices: Vertices,
    /// The buffer of indices; 0 without indices.
    pub(in crate::intercept::gl) indices: u32,
}

pub(in crate::intercept::gl) struct Known {
    /// Versions of the buffer of positions and of the buffer of indices.
    pub(in crate::intercept::gl) versions: [u64; 2],
    pub(in crate::intercept::gl) bounds: Bounds,
}

/// Greatest number of ranges that are stored.
pub(in crate::intercept::gl) const MOST_RANGES: usize = 1 << 14;

/// Greatest number of bytes that are read in a frame. A single range may be larger.
pub(in crate::intercept::gl) const MOST_BYTES_IN_FRAME: usize = 16 << 20;

impl Ranges {
    /// Begins a new count if the frame has changed.
    pub(in crate::intercept::gl) fn follow(&mut self, frame: u64) {
        if frame != self.frame {
            (self.frame, self.spent, self.full) = (frame, 0, false);
        }
    }

    pub(in crate::intercept::gl) fn afford(&mut self, bytes: usize) -> bool {
        let affordable = self.spent == 0 || self.spent.saturating_add(bytes) <= MOST_BYTES_IN_FRAME;
        self.spent += if affordable { bytes } else { 0 };
        affordable
    }
}

/// An array of vectors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Layout {
    /// Name of the buffer; 0 = the program's memory.
    pub buffer: u32,
    /// Address in the program's memory, or offset in the buffer.
    pub start: usize,
    /// Bytes from one vector to the next.
    pub stride: usize,
    pub(in crate::intercept::gl) components: usize,
    pub(in crate::intercept::gl) kind: u32,
    /// True if integers stand for −1…1 or 0…1.
    pub(in crate::intercept::gl) normalised: bool,
}

#[cfg(test)]
mod tests {
    use super::{MOST_BYTES_IN_FRAME, Ranges};

    #[test]
    fn a_frame_reads_so_many_bytes_or_one_range() {
        let mut ranges = Ranges::default();
        assert!(ranges.afford(2 * MOST_BYTES_IN_FRAME) && !ranges.afford(1));
        ranges.follow(0);
        assert!(!ranges.afford(1), "the same frame");
        ranges.follow(1);
        assert!(ranges.afford(MOST_BYTES_IN_FRAME - 10) && ranges.afford(10) && !ranges.afford(1));
        assert!(!ranges.afford(usize::MAX));
    }
}
