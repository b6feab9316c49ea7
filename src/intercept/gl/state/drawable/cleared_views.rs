//! Views whose content is known to be the clear colour, but for a part.

use crate::backend::gl::ClearedViews;
use crate::correct::TexelSpan;

/// Content of each view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Content {
    /// The colour that every view was cleared to; `None`: not known.
    cleared: Option<[f32; 3]>,
    /// The views that were drawn to since, a bit each.
    drawn: u64,
    /// For each view the texels of the atlas that were drawn to.
    touched: [TexelSpan; VIEWS],
}

/// More views are not followed.
pub(in crate::intercept::gl) const VIEWS: usize = 64;

impl Default for Content {
    fn default() -> Self {
        Self { cleared: None, drawn: 0, touched: [TexelSpan::NOTHING; VIEWS] }
    }
}

impl Content {
    /// Something came into a view, somewhere.
    pub fn draw(&mut self, view: usize) {
        self.draw_within(view, TexelSpan::EVERYTHING);
    }

    /// Something came into these texels of a view.
    pub fn draw_within(&mut self, view: usize, texels: TexelSpan) {
        match self.touched.get_mut(view) {
            Some(touched) => {
                self.drawn |= 1 << view;
                *touched = touched.union(&texels);
            }
            None => self.forget(),
        }
    }

    /// Anything may be in any view.
    pub fn forget(&mut self) {
        self.cleared = None;
    }

    pub(in crate::intercept::gl) fn clear(&mut self, color: Option<[f32; 3]>) {
        *self = Self { cleared: color, ..Self::default() };
    }

    /// The views that hold nothing but one colour; `None`: no view is known to.
    pub fn views_cleared(&self) -> Option<ClearedViews<'_>> {
        self.cleared.map(|color| ClearedViews { views: !self.drawn, color, touched: &self.touched })
    }
}
