//! Finds windows with far fewer pixels than the outputs of the rig have.

use super::{log, settings};
use crate::runtime::Session;

/// Number of frames after which a window has its size: window managers enlarge windows, and
/// programs open small ones while they load.
const SETTLED: u32 = 20;

/// Reports once that a window is too small, and which size fits.
#[derive(Clone, Copy, Debug, Default)]
pub struct SmallWindow {
    frames: u32,
}

impl SmallWindow {
    /// Examines the window at the end of a frame.
    pub fn look(&mut self, session: &Session) {
        self.frames = self.frames.saturating_add(1);
        // A size that the user has given is meant.
        let is_given = settings::settings().is_some_and(|settings| settings.window_size.is_some());
        if self.frames == SETTLED
            && !is_given
            && let Some(remark) = session.too_small()
        {
            log::once(&remark);
        }
    }
}
