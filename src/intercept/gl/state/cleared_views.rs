//! Views whose content is known to be the clear colour, but for a part.

use crate::backend::gl::Blank;
use crate::correct::Texels;

/// What each view holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Content {
    /// The colour that every view was cleared to; `None`: not known.
    cleared: Option<[f32; 3]>,
    /// The views that were drawn to since, a bit each.
    drawn: u64,
    /// For each view the texels of the atlas that were drawn to.
    touched: [Texels; VIEWS],
}

/// More views are not followed.
pub(in crate::intercept::gl) const VIEWS: usize = 64;

/// No texels.
pub const NOTHING: Texels = [i32::MAX, i32::MAX, i32::MIN, i32::MIN];
pub(in crate::intercept::gl) const EVERYTHING: Texels = [i32::MIN, i32::MIN, i32::MAX, i32::MAX];

impl Default for Content {
    fn default() -> Self {
        Self { cleared: None, drawn: 0, touched: [NOTHING; VIEWS] }
    }
}

impl Content {
    /// Something came into a view, somewhere.
    pub fn draw(&mut self, view: usize) {
        self.draw_within(view, EVERYTHING);
    }

    /// Something came into these texels of a view.
    pub fn draw_within(&mut self, view: usize, [left, bottom, right, top]: Texels) {
        match self.touched.get_mut(view) {
            Some(touched) => {
                self.drawn |= 1 << view;
                let [x0, y0, x1, y1] = *touched;
                *touched = [x0.min(left), y0.min(bottom), x1.max(right), y1.max(top)];
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
    pub fn blank(&self) -> Option<Blank<'_>> {
        self.cleared.map(|color| Blank { views: !self.drawn, color, touched: &self.touched })
    }
}
