//! Matrices that a program reads from vertex attributes.

use crate::intercept::gl::state::vertex_input::vertex_ranges::Layout;
use glam::DMat4;

/// A matrix of a vertex shader's attributes.
pub struct AttributeMatrix {
    /// The first of its four locations.
    pub(in crate::intercept::gl) location: u32,
    /// True if it is declared as a matrix. If not, four vectors may be its columns or rows.
    pub(in crate::intercept::gl) declared: bool,
    /// Number of reads in a row that found no lens, of vectors.
    pub(in crate::intercept::gl) misses: u8,
    /// Rank of its name: the lower, the higher its priority.
    pub(in crate::intercept::gl) rank: u8,
    pub(in crate::intercept::gl) value: DMat4,
    /// Arrays from which the columns were read, and the version of their buffer at that time.
    pub(in crate::intercept::gl) read: Option<([Layout; 4], u64)>,
}

impl AttributeMatrix {
    /// Returns a matrix that was not read yet.
    pub(in crate::intercept::gl) fn new(location: u32, rank: u8, declared: bool) -> Self {
        Self { location, declared, misses: 0, rank, value: DMat4::ZERO, read: None }
    }
}
