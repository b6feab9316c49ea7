//! The set of views that a draw goes to.

/// The views that a draw goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Views {
    /// One bit for each view that the draw goes to.
    pub(in crate::intercept::gl) seen: u64,
    /// True if `DrawState::areas` holds the area of the draw in each of these views.
    pub(in crate::intercept::gl) bounded: bool,
}

impl Views {
    /// Every view.
    pub const ALL: Self = Self { seen: u64::MAX, bounded: false };

    /// One view.
    pub fn only(index: usize) -> Self {
        Self { seen: if index < 64 { 1 << index } else { 0 }, bounded: false }
    }

    /// Returns those of the views that also have a bit in `views`.
    pub fn within(self, views: u64) -> Self {
        Self { seen: self.seen & views, ..self }
    }

    /// True if the draw goes to this view.
    pub fn contain(self, index: usize) -> bool {
        index >= 64 || self.seen >> index & 1 != 0
    }

    /// True if the area of the draw in each view is known.
    pub fn bounded(self) -> bool {
        self.bounded
    }

    /// Returns the last of `count` views that the draw goes to.
    pub fn last(self, count: usize) -> Option<usize> {
        (0..count).rev().find(|index| self.contain(*index))
    }
}
