//! Use of the flat panel.

/// Number of frames without a use after which the panel is removed.
const IDLE: u32 = 30;

/// How long the program has drawn nothing to the panel.
#[derive(Debug, Default)]
pub struct PanelUse {
    /// Number of frames since the last use.
    idle: u32,
    is_removed: bool,
}

impl PanelUse {
    /// Notes a use.
    pub fn note_used(&mut self) {
        self.idle = 0;
    }

    /// Notes that the panel is removed, which happens once.
    pub fn note_removed(&mut self) {
        self.is_removed = true;
    }

    /// True if the panel should be removed.
    pub fn is_over(&self) -> bool {
        self.idle >= IDLE && !self.is_removed
    }

    /// Handles the end of a frame.
    pub fn end_frame(&mut self) {
        self.idle = self.idle.saturating_add(1);
    }
}
