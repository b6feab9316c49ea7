//! The set of views that a draw goes to.

/// The views that a draw goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Views {
    /// One bit each.
    pub(in crate::intercept::gl) seen: u64,
    /// `DrawState::areas` says where in each of them.
    pub(in crate::intercept::gl) bounded: bool,
}

impl Views {
    /// Every view.
    pub const ALL: Self = Self { seen: u64::MAX, bounded: false };

    /// One view.
    pub fn only(index: usize) -> Self {
        Self { seen: if index < 64 { 1 << index } else { 0 }, bounded: false }
    }

    /// Those that have a bit of `views`, too.
    pub fn within(self, views: u64) -> Self {
        Self { seen: self.seen & views, ..self }
    }

    /// True if the draw goes to this view.
    pub fn contain(self, index: usize) -> bool {
        index >= 64 || self.seen >> index & 1 != 0
    }

    /// True if it is known where in each view the draw comes to be.
    pub fn bounded(self) -> bool {
        self.bounded
    }

    /// The last of `count` views that the draw goes to.
    pub fn last(self, count: usize) -> Option<usize> {
        (0..count).rev().find(|index| self.contain(*index))
    }
}
