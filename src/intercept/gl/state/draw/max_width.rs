//! The greatest width of points and lines.

/// Greatest width of points and lines so far, pixels. A primitive that is wider than a pixel
/// reaches into views that do not show its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaxWidth(f32);

impl Default for MaxWidth {
    fn default() -> Self {
        Self(1.0)
    }
}

impl MaxWidth {
    /// The program set a point's or a line's width. It counts for good: a display list, or a pop of
    /// attributes, may bring it back at any time.
    pub fn note(&mut self, width: f32) {
        self.0 = if width.is_nan() { f32::INFINITY } else { self.0.max(width) };
    }

    /// Points have sizes that nobody here knows.
    pub fn note_unknown(&mut self) {
        self.0 = f32::INFINITY;
    }

    /// True if something may reach over the border of its tile into the next one, which the gutter
    /// keeps a pixel away.
    pub fn exceeds_gutter(self) -> bool {
        self.0 > 2.0
    }

    /// Number of pixels that a primitive may cover beside its vertices: half the width, and what
    /// smoothing and the rasteriser's own grid add.
    pub fn spread(self) -> f64 {
        0.5 * f64::from(self.0) + 2.0
    }
}
