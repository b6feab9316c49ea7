//! Decision whether draws are issued for each view, and the reason if they are not.

use crate::intercept::process::log;
use crate::intercept::scene::obstacle::Obstacle;
use std::sync::OnceLock;

/// The reasons why a device's draws are not issued for each view.
#[derive(Default)]
pub struct Flatness {
    /// Text for the log and the statistics, if the program's picture is not made from views.
    note: OnceLock<String>,
    /// Reason why a pipeline has no variants.
    pipeline: OnceLock<Obstacle>,
}

impl Flatness {
    /// True if draws are issued for each view.
    pub fn draws_views(&self) -> bool {
        self.note.get().is_none()
    }

    /// Shows the program's picture flat from now on. The log gives the reason.
    pub fn show_flat(&self, why: &Obstacle) {
        let Some(reason) = why.reason() else { return };
        let note = format!(
            "Vulkan: the program's picture is shown flat, on the panel; its draws are not issued for each view: {reason}"
        );
        if self.note.set(note.clone()).is_ok() {
            log::once(&note);
        }
    }

    /// Shows the program's own picture in windows from now on. The log gives the reason.
    pub fn show_own(&self, why: &str) {
        let note = format!("Vulkan: the window has the program's own picture from now on: {why}");
        log::once(&note);
        let _ = self.note.set(note);
    }

    /// Text for the log and the statistics, if draws are not issued for each view.
    pub fn note(&self) -> Option<String> {
        self.note.get().cloned()
    }

    /// Notes why a pipeline has no variants. This matters when it draws to a window.
    pub fn note_pipeline(&self, why: &Obstacle) {
        let _ = self.pipeline.set(why.clone());
    }

    /// Returns the reason why a pipeline has no variants.
    pub fn pipeline_obstacle(&self) -> Obstacle {
        self.pipeline.get().cloned().unwrap_or_else(|| "a pipeline that is not known".into())
    }
}
