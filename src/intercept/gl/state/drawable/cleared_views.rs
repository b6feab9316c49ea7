//! Views whose content is known to be the clear colour, except for a part.

use crate::backend::gl::ClearedViews;
use crate::correct::TexelSpan;

/// Content of each view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewContents {
    /// Colour to which every view was cleared; `None`: not known.
    cleared: Option<[f32; 3]>,
    /// Views that were drawn to since the clear, a bit each.
    drawn: u64,
    /// For each view, the texels of the atlas that were drawn to.
    touched: [TexelSpan; VIEWS],
}

/// Greatest number of views that are followed.
pub(in crate::intercept::gl) const VIEWS: usize = 64;

impl Default for ViewContents {
    fn default() -> Self {
        Self { cleared: None, drawn: 0, touched: [TexelSpan::NOTHING; VIEWS] }
    }
}

impl ViewContents {
    /// Notes a draw at an unknown place of a view.
    pub fn draw(&mut self, view: usize) {
        self.draw_within(view, TexelSpan::EVERYTHING);
    }

    /// Notes a draw into these texels of a view.
    pub fn draw_within(&mut self, view: usize, texels: TexelSpan) {
        match self.touched.get_mut(view) {
            Some(touched) => {
                self.drawn |= 1 << view;
                *touched = touched.union(&texels);
            }
            None => self.forget(),
        }
    }

    /// Notes that any view may have any content.
    pub fn forget(&mut self) {
        self.cleared = None;
    }

    pub(in crate::intercept::gl) fn clear(&mut self, color: Option<[f32; 3]>) {
        *self = Self { cleared: color, ..Self::default() };
    }

    /// Returns the views that hold only one colour; `None`: no such view is known.
    pub fn views_cleared(&self) -> Option<ClearedViews<'_>> {
        self.cleared.map(|color| ClearedViews { views: !self.drawn, color, touched: &self.touched })
    }
}
