//! Off-screen draws that were issued once per view.

use crate::intercept::gl::state::draw::views::Views;

/// Draws that were issued once per view.
#[derive(Default)]
pub struct Issued {
    /// Number of these draws.
    pub draws: u64,
    /// For each view, the number of draws that it got, and the number that were left out of it.
    views: Vec<[u64; 2]>,
}

impl Issued {
    /// Counts a draw that went to the views `shown`, of `count` views.
    pub(in crate::intercept::gl) fn count(&mut self, shown: Views, count: usize) {
        self.draws += 1;
        self.views.resize(count, [0; 2]);
        for (index, counts) in self.views.iter_mut().enumerate() {
            counts[usize::from(!shown.contain(index))] += 1;
        }
    }

    /// Forgets the numbers of the views, as the views have changed.
    pub fn forget_views(&mut self) {
        self.views.clear();
    }

    /// Returns the number of draws that a view got, and the number that were left out of it.
    pub fn of_view(&self, index: usize) -> [u64; 2] {
        self.views.get(index).copied().unwrap_or_default()
    }
}
