//! Flat draws that show images which are drawn once per view.

use crate::backend::gl::driver::api::Gl;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::state::offscreen::coverage::Measure;
use crate::intercept::gl::state::offscreen::images::Set;
use crate::intercept::gl::state::offscreen::single_sample::SingleSampleImage;

/// Effect of a flat draw to the window.
pub enum Shows {
    /// The draw fills this rectangle of the window with pictures that are drawn once per view.
    Pictures(Set, LowerLeftRect),
    /// The draw is flat, and has to be measured.
    Unknown(Measure),
    /// The draw is flat.
    Nothing,
}

/// Pictures of the window's size, one for each view, into which such a draw goes. In them each
/// texel that the program samples has its own pixel, and `gl_FragCoord` has the same value as in
/// the window.
#[derive(Default)]
pub struct DisplayedPictures {
    pub(in crate::intercept::gl) canvases: Vec<SingleSampleImage>,
    /// Number of the window's draws after which this rectangle of these pictures had the same
    /// content as the views.
    pub(in crate::intercept::gl) current: Option<(u64, LowerLeftRect)>,
}

impl DisplayedPictures {
    /// Deletes everything.
    pub fn destroy(&self, gl: &Gl) {
        for canvas in &self.canvases {
            canvas.destroy(gl);
        }
    }
}
