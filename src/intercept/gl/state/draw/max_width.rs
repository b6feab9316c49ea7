//! The greatest width of points and lines.

/// Greatest width of points and lines so far, in pixels. A primitive that is wider than a pixel
/// reaches into views that do not show its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaxWidth(f32);

impl Default for MaxWidth {
    fn default() -> Self {
        Self(1.0)
    }
}

impl MaxWidth {
    /// Notes a width of points or lines that the program set. It is never forgotten, as a display
    /// list or `glPopAttrib` may restore it at any time.
    pub fn note(&mut self, width: f32) {
        self.0 = if width.is_nan() { f32::INFINITY } else { self.0.max(width) };
    }

    /// Notes that points have sizes that Cupola does not know.
    pub fn note_unknown(&mut self) {
        self.0 = f32::INFINITY;
    }

    /// True if a primitive may reach over the border of its tile into the next tile. The gutter
    /// between tiles is one pixel wide.
    pub fn exceeds_gutter(self) -> bool {
        self.0 > 2.0
    }

    /// Number of pixels that a primitive may cover beside its vertices: half the width, and the
    /// pixels that smoothing and the rasteriser's grid add.
    pub fn spread(self) -> f64 {
        0.5 * f64::from(self.0) + 2.0
    }
}
