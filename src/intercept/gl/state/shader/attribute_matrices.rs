//! Matrices that a program reads from vertex attributes.

use crate::intercept::gl::state::vertex_input::vertex_ranges::Layout;
use crate::intercept::scene::lens::Candidate;
use glam::DMat4;

/// Number of reads without a lens after which vectors are read in few draws: a buffer that is written
/// for each draw would be waited for each time.
const MOST_MISSES: u8 = 60;

/// Number of draws of which one reads such vectors.
const RARELY: u8 = 60;

/// A matrix of a vertex shader's attributes.
pub struct AttributeMatrix {
    /// The first of its four locations.
    pub(in crate::intercept::gl) location: u32,
    /// True if it is declared as a matrix. If not, four vectors may be its columns or rows.
    pub(in crate::intercept::gl) declared: bool,
    /// True if vectors have had a lens. They are a matrix then.
    had_lens: bool,
    /// Number of reads of vectors that found no lens.
    misses: u8,
    /// Number of draws since the last one that read vectors without a lens.
    skipped: u8,
    /// Rank of its name: the lower, the higher its priority.
    pub(in crate::intercept::gl) rank: u8,
    /// Zero for vectors without a lens.
    pub(in crate::intercept::gl) value: DMat4,
    /// Arrays from which the columns were read, and the version of their buffer at that time.
    pub(in crate::intercept::gl) read: Option<([Layout; 4], u64)>,
}

impl AttributeMatrix {
    /// Returns a matrix that was not read yet.
    pub(in crate::intercept::gl) fn new(location: u32, rank: u8, declared: bool) -> Self {
        Self { location, declared, had_lens: false, misses: 0, skipped: 0, rank, value: DMat4::ZERO, read: None }
    }

    /// True if the next draw is to read vectors, if they changed.
    pub(in crate::intercept::gl) fn is_due(&mut self) -> bool {
        if self.had_lens || self.misses < MOST_MISSES {
            return true;
        }
        self.skipped = (self.skipped + 1) % RARELY;
        self.skipped == 0
    }

    /// Examines the value of vectors that were read.
    pub(in crate::intercept::gl) fn examine_vectors(&mut self) {
        if Candidate::either(self.rank, &self.value).lens().is_some() {
            self.had_lens = true;
        } else {
            // Vectors of vertices are no matrix, and neither are colours of instances.
            self.value = DMat4::ZERO;
            self.misses = self.misses.saturating_add(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{AttributeMatrix, MOST_MISSES, RARELY};
    use glam::DMat4;

    #[test]
    fn vectors_without_a_lens_are_read_rarely_but_not_never() {
        let mut vectors = AttributeMatrix::new(2, 1, false);
        for _ in 0..MOST_MISSES {
            assert!(vectors.is_due());
            vectors.value = DMat4::from_diagonal([0.5, 0.5, 0.1, 1.0].into());
            vectors.examine_vectors();
            assert_eq!(vectors.value, DMat4::ZERO);
        }
        let due = (0..3 * u32::from(RARELY)).filter(|_| vectors.is_due()).count();
        assert_eq!(due, 3);
        vectors.value = DMat4::from_cols_array_2d(&[
            [0.7, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, -1.01, -1.0],
            [0.0, 0.0, -0.2, 0.0],
        ]);
        vectors.examine_vectors();
        assert_ne!(vectors.value, DMat4::ZERO);
        for _ in 0..2 * MOST_MISSES {
            assert!(vectors.is_due(), "shadows of each frame do not end the search");
            vectors.value = DMat4::IDENTITY;
            vectors.examine_vectors();
        }
    }
}
