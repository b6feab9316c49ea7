//! Images that are drawn once per view, as flat draws show them.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::state::offscreen::coverage::Measure;
use crate::intercept::gl::state::offscreen::images::Set;
use crate::intercept::gl::state::offscreen::single_sample::SingleSampleImage;

/// Effect of a flat draw to the window.
pub enum Shows {
    /// It fills the window with pictures that are drawn once per view.
    Pictures(Set),
    /// It is flat, and to be measured.
    Unknown(Measure),
    /// It is flat.
    Nothing,
}

/// Pictures of the window's size, one for each view, into which it is shown: there each texel that
/// the program samples has its pixel, and `gl_FragCoord` is what it would be in the window.
#[derive(Default)]
pub struct DisplayedPictures {
    pub(in crate::intercept::gl) canvases: Vec<SingleSampleImage>,
    /// The number of the window's draws after which the canvases had what the views have.
    pub(in crate::intercept::gl) current: Option<u64>,
}

impl DisplayedPictures {
    /// Deletes everything.
    pub fn destroy(&self, gl: &Gl) {
        for canvas in &self.canvases {
            canvas.destroy(gl);
        }
    }
}
