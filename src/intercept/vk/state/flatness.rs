//! Whether draws are issued for each view, and why not.

use crate::intercept::log;
use crate::intercept::scene::obstacle::Obstacle;
use std::sync::OnceLock;

/// The reasons for which a device's draws are not issued for each view.
#[derive(Default)]
pub struct Flatness {
    /// Why the program's picture is shown flat; empty as long as it is not.
    reason: OnceLock<String>,
    /// Why some pipeline has no variants.
    pipeline: OnceLock<Obstacle>,
}

impl Flatness {
    /// Whether draws are issued for each view.
    pub fn draws_views(&self) -> bool {
        self.reason.get().is_none()
    }

    /// From now on the program's picture is shown flat; the log says why.
    pub fn show_flat(&self, why: &Obstacle) {
        let Some(reason) = why.reason() else { return };
        if self.reason.set(reason.to_owned()).is_ok() {
            log::once(&self.note().unwrap_or_default());
        }
    }

    /// Text for the log and the statistics, if the program is shown flat.
    pub fn note(&self) -> Option<String> {
        let why = self.reason.get()?;
        Some(format!(
            "Vulkan: the program's picture is shown flat, on the panel; its draws are not issued for each view: {why}"
        ))
    }

    /// Notes why a pipeline has no variants; that matters when it draws to a window.
    pub fn note_pipeline(&self, why: &Obstacle) {
        let _ = self.pipeline.set(why.clone());
    }

    /// Why some pipeline has no variants.
    pub fn pipeline_obstacle(&self) -> Obstacle {
        self.pipeline.get().cloned().unwrap_or_else(|| "a pipeline that is not known".into())
    }
}
