//! State of a Begin/End: the phase and what was recorded.

use crate::intercept::gl::state::compat::vertex_recorder::Recorder;
use crate::intercept::gl::state::draw::bounds::Bounds;

/// Where the program is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// Outside of Begin/End, or in one that is passed on as it comes.
    #[default]
    Outside,
    /// Commands are recorded.
    Recording,
    /// Commands go into a list of ours, and are recorded besides.
    IntoList,
}

/// The Begin/End that the program is in.
pub struct Immediate {
    /// Where the program is.
    pub phase: Phase,
    pub(in crate::intercept::gl) mode: u32,
    pub(in crate::intercept::gl) recorder: Recorder,
    /// Around the vertices since `glBegin`.
    pub(in crate::intercept::gl) bounds: Bounds,
    /// Our list for what cannot be played back; 0 = not made yet.
    pub(in crate::intercept::gl) list: u32,
    /// Attributes that were recorded from here on hold after the list.
    pub(in crate::intercept::gl) trailing: usize,
}

impl Default for Immediate {
    fn default() -> Self {
        let (phase, recorder, bounds) = (Phase::Outside, Recorder::default(), Bounds::EMPTY);
        Self { phase, mode: 0, recorder, bounds, list: 0, trailing: 0 }
    }
}

impl Immediate {
    /// Between `glBegin` and `glEnd` of a draw of ours.
    pub fn under_way(&self) -> bool {
        self.phase != Phase::Outside
    }

    pub(in crate::intercept::gl) fn begin(&mut self, mode: u32) {
        self.phase = Phase::Recording;
        self.mode = mode;
        self.recorder.clear();
        self.bounds = Bounds::EMPTY;
        self.trailing = 0;
    }
}
