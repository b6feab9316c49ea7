//! Numbers that are counted for `--stats`.

use crate::intercept::scene::culling_program::Places;
use crate::intercept::scene::flat_program::MissingLenses;

/// Counts for `--stats`.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// Presented frames.
    pub frames: u64,
    /// Presented frames that were not corrected, because nothing of the window was visible.
    pub hidden_frames: u64,
    /// Draws of the program to its window.
    pub draws_seen: u64,
    /// Draws issued to each view.
    pub draws_issued: Vec<u64>,
    /// Flat draws issued to the panel.
    pub panel_draws: u64,
    /// Draws issued to the primary view.
    pub primary_draws: u64,
    /// Draws of the scene whose area was known.
    pub bounded_draws: u64,
    /// Positions of these draws in the program's own picture.
    pub places: Places,
    /// Number of times that the unsampled areas of the views were closed.
    pub closings: u64,
    /// Shader programs that were linked for Cupola.
    pub linked: u64,
    /// Draws by the way their projection was found.
    pub found: FoundBy,
    /// Draws without a lens.
    pub missing: MissingLenses,
}

/// Number of draws by the way in which their projection was found. Counting allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct FoundBy([(&'static str, u64); 8]);

impl FoundBy {
    /// Counts one draw whose projection was found in this way. Only the first eight ways are
    /// counted.
    pub fn count(&mut self, how: &'static str) {
        if let Some(entry) = self.0.iter_mut().find(|e| e.1 == 0 || e.0 == how) {
            *entry = (how, entry.1 + 1);
        }
    }

    /// Returns the ways that were found, with their numbers of draws.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, u64)> + '_ {
        self.0.iter().copied().filter(|e| e.1 > 0)
    }
}
