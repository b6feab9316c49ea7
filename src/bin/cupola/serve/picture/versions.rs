//! Versions of the rig, by the checksums of their texts. Each frame of the program has the checksum
//! of the rig that it shows.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Number of texts that are remembered.
const TEXTS: usize = 256;
/// Time after a change in which frames that do not show it are left out: the program shows most
/// changes sooner, and each picture costs time that the next one needs.
const PATIENCE: Duration = Duration::from_millis(200);
/// Time after a change in which somebody may make the next one.
const BUSY: Duration = Duration::from_secs(2);

/// Texts that were written for the program.
#[derive(Debug, Default)]
pub struct Versions {
    /// Checksum and version, newest first.
    written: VecDeque<(u64, u64)>,
    /// Time of the last change.
    changed: Option<Instant>,
}

impl Versions {
    /// Notes that the text with this checksum was written. It has this version.
    pub fn note(&mut self, sum: u64, version: u64) {
        if self.written.front() == Some(&(sum, version)) {
            return;
        }
        // The first text is no change.
        self.changed = (!self.written.is_empty()).then(Instant::now);
        self.written.push_front((sum, version));
        self.written.truncate(TEXTS);
    }

    /// True while somebody makes changes.
    pub fn are_changing(&self) -> bool {
        self.changed.is_some_and(|changed| changed.elapsed() < BUSY)
    }

    /// Version of the text with this checksum.
    pub fn of(&self, sum: u64) -> Option<u64> {
        self.written.iter().find(|(known, _)| *known == sum).map(|(_, version)| *version)
    }

    /// True if a frame with this checksum shows an older rig than the newest, nothing that is newer
    /// than the version `shown`, and the last change was just made.
    pub fn is_outdated(&self, sum: u64, shown: Option<u64>) -> bool {
        let newest = self.written.front().map(|(_, version)| *version);
        let is_soon = self.changed.is_some_and(|changed| changed.elapsed() < PATIENCE);
        is_soon && self.of(sum).is_some_and(|version| Some(version) < newest && Some(version) <= shown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_from_before_a_change_are_left_out_for_a_while() {
        let mut versions = Versions::default();
        versions.note(11, 0);
        assert!(!versions.is_outdated(11, Some(0)), "there was no change");
        versions.note(22, 1);
        versions.note(33, 2);
        assert_eq!([11, 22, 33, 44].map(|sum| versions.of(sum)), [Some(0), Some(1), Some(2), None]);
        // Of a drag, each version that is newer than the shown one is shown.
        let outdated = [11, 22, 33, 44].map(|sum| versions.is_outdated(sum, Some(0)));
        assert_eq!(outdated, [true, false, false, false]);
        assert!(versions.is_outdated(22, Some(1)) && versions.is_outdated(11, Some(1)));
        versions.changed = Instant::now().checked_sub(PATIENCE);
        assert!(!versions.is_outdated(11, Some(0)), "the program may be slow");
    }
}
