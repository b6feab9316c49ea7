//! Names of display lists: those that Cupola reserves for itself, and those that it keeps for the
//! program.
//!
//! Drivers give names above all that are in use. So after Cupola's first list they would give the
//! program higher names than without Cupola. Cupola gives these names itself.

use crate::backend::gl::driver::api::Gl;
use std::ops::Range;

/// Number of names that are reserved for Cupola at once.
pub(in crate::intercept::gl) const OWN_NAMES: u32 = 1024;

/// Number of names below those of Cupola that are left to the program. Old programs use names from
/// 1 on without reserving them.
const PROGRAM_NAMES: u32 = 8192;

/// Names of display lists of a share group.
#[derive(Default)]
pub(in crate::intercept::gl) struct ListNames {
    /// Names reserved for Cupola that are not in use.
    own: Vec<u32>,
    /// First names of the blocks of [`OWN_NAMES`] names that are reserved for Cupola.
    blocks: Vec<u32>,
    /// Names that the driver would give the program next if Cupola had no names.
    kept: Range<u32>,
}

impl ListNames {
    /// Reserves names for Cupola if none are left.
    pub(in crate::intercept::gl) fn reserve(&mut self, gl: &Gl) {
        if !self.own.is_empty() {
            return;
        }
        // SAFETY: reserves names, and frees those that are not for Cupola.
        let free = unsafe { gl.gen_lists((PROGRAM_NAMES + OWN_NAMES) as i32) };
        if free == 0 {
            return;
        }
        // SAFETY: as above.
        unsafe { gl.delete_lists(free, PROGRAM_NAMES as i32) };
        let first = free + PROGRAM_NAMES;
        self.own.extend((first..first + OWN_NAMES).rev());
        self.blocks.push(first);
        if self.kept.is_empty() {
            self.kept = free..first;
        }
    }

    /// Returns a name for a list of Cupola; 0 if the driver gives none.
    pub(in crate::intercept::gl) fn own(&mut self, gl: &Gl) -> u32 {
        self.reserve(gl);
        self.own.pop().unwrap_or_default()
    }

    /// A list of Cupola is no longer needed.
    pub(in crate::intercept::gl) fn give_back(&mut self, name: u32) {
        self.own.push(name);
    }

    /// Takes successive names for the program of which none `exists`. Returns the first one. `None`:
    /// the driver must give them.
    pub(in crate::intercept::gl) fn take(&mut self, count: u32, exists: impl Fn(u32) -> bool) -> Option<u32> {
        if count == 0 || self.kept.is_empty() {
            return None;
        }
        let mut first = self.kept.start;
        let mut next = first;
        while next - first < count {
            if next >= self.kept.end {
                self.kept = 0..0;
                return None;
            }
            if exists(next) {
                first = next + 1;
            }
            next += 1;
        }
        self.kept.start = next;
        Some(first)
    }

    /// The program has made a list of this name. Drivers give higher names from then on.
    pub(in crate::intercept::gl) fn note(&mut self, list: u32) {
        if list >= self.kept.start {
            self.kept = list.saturating_add(1)..self.kept.end;
        }
    }

    /// Returns the parts of a range of names, first name and number, without those of Cupola.
    pub(in crate::intercept::gl) fn of_program(&self, first: u32, count: u32) -> Vec<(u32, u32)> {
        let end = first.saturating_add(count);
        let (mut parts, mut start) = (Vec::new(), first);
        let mut blocks: Vec<u32> = self.blocks.iter().copied().filter(|block| (first..end).contains(block)).collect();
        blocks.sort_unstable();
        for block in blocks {
            parts.push((start, block - start));
            start = (block + OWN_NAMES).min(end);
        }
        parts.push((start, end - start));
        parts.retain(|(_, count)| *count > 0);
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::ListNames;

    #[test]
    fn a_long_range_of_names_spares_the_lists_of_cupola() {
        let names = ListNames { blocks: vec![20_000, 8193], ..ListNames::default() };
        assert_eq!(names.of_program(1, 8192), [(1, 8192)]);
        assert_eq!(names.of_program(1, 100_000), [(1, 8192), (9217, 10_783), (21_024, 78_977)]);
        assert_eq!(names.of_program(8193, 5), []);
        assert_eq!(names.of_program(20, 0), []);
    }

    #[test]
    fn the_program_gets_the_names_that_the_driver_would_give() {
        let mut names = ListNames::default();
        let none = |_: u32| false;
        assert_eq!(names.take(1, none), None, "the driver gives them");
        names.kept = 4..100;
        assert_eq!((names.take(3, none), names.take(0, none), names.take(1, none)), (Some(4), None, Some(7)));
        names.note(2);
        assert_eq!(names.take(1, none), Some(8), "a lower name");
        names.note(20);
        assert_eq!(names.take(1, none), Some(21));
        assert_eq!(names.take(2, |name| name == 23), Some(24), "23 is in use");
        assert_eq!(names.take(75, none), None, "26 to 99 are too few");
        assert_eq!(names.take(1, none), None, "higher names are in use");
        names.kept = 4..100;
        names.note(5000);
        assert_eq!(names.take(1, none), None);
    }
}
