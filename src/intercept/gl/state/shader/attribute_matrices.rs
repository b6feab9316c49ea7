//! Matrices that a program reads from vertex attributes.

use crate::intercept::gl::state::vertex_input::vertex_ranges::Layout;
use glam::DMat4;

/// A matrix of a vertex shader's attributes.
pub struct AttributeMatrix {
    /// The first of its four locations.
    pub(in crate::intercept::gl) location: u32,
    /// Rank of its name: the lower, the higher its priority.
    pub(in crate::intercept::gl) rank: u8,
    pub(in crate::intercept::gl) value: DMat4,
    /// Arrays from which the columns were read, and the version of their buffer at that time.
    pub(in crate::intercept::gl) read: Option<([Layout; 4], u64)>,
}
