//! Number of draws in a frame.

use crate::runtime::session::Extras;

/// Number of draws, as seen so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DrawCount {
    /// Number of draws before the present frame.
    before: u64,
    /// Number of draws of the last frame.
    last: u64,
    /// Number of frames in a row with about the same number of draws.
    steady: u32,
    /// True if the program tests stencils, which may have to outlast a frame.
    stencil: bool,
    /// Number of draws for which the views are planned, once it is known.
    draws: Option<u32>,
}

/// Number of frames in a row that must have about the same number of draws.
pub(in crate::intercept::gl) const STEADY_FRAMES: u32 = 8;

impl DrawCount {
    /// Handles the end of a frame; `seen` is the number of draws since the beginning.
    pub fn end_frame(&mut self, seen: u64) {
        let draws = seen - self.before;
        let alike = draws > 0 && draws.abs_diff(self.last) * 4 <= self.last.max(draws);
        self.steady = if alike { self.steady + 1 } else { 0 };
        (self.before, self.last) = (seen, draws);
    }

    /// True if the program tests stencils.
    pub fn tests_stencil(&self) -> bool {
        self.stencil
    }

    /// True if the number of draws to plan for is known.
    pub fn is_planned(&self) -> bool {
        self.draws.is_some()
    }

    /// Notes that the program switched the stencil test on.
    pub fn note_stencil(&mut self) {
        self.stencil = true;
    }

    /// Returns the number of draws to plan for, a power of two. Returns it once, when it is known.
    pub fn take(&mut self) -> Option<u32> {
        if self.draws.is_some() || self.steady < STEADY_FRAMES {
            return None;
        }
        self.draws = Some(u32::try_from(self.last).unwrap_or(u32::MAX).clamp(FEWEST, MOST).next_power_of_two());
        self.draws
    }

    /// Returns `extras` with the number of draws, if it is known. Views that did not depend on the
    /// number may depend on it for another rig.
    pub fn extras(&self, extras: Extras) -> Extras {
        Extras { draws: self.draws.or(extras.draws), ..extras }
    }
}

/// Fewest draws for which views are planned. The other costs of a view equal those of this number
/// of draws.
pub(in crate::intercept::gl) const FEWEST: u32 = 16;
pub(in crate::intercept::gl) const MOST: u32 = 1 << 14;

#[cfg(test)]
mod tests {
    use super::{DrawCount, STEADY_FRAMES};

    #[test]
    fn the_number_is_known_once_it_is_steady_and_given_once() {
        let mut load = DrawCount::default();
        let mut seen = 0;
        let mut frame = |load: &mut DrawCount, draws: u64| {
            seen += draws;
            load.end_frame(seen);
        };
        for draws in [0, 0, 500, 3, 3, 3] {
            frame(&mut load, draws);
            assert_eq!(load.take(), None);
        }
        for _ in 0..STEADY_FRAMES {
            frame(&mut load, 100);
        }
        assert_eq!(load.take(), None, "the first of them was a jump");
        frame(&mut load, 110);
        assert_eq!(load.take(), Some(128));
        frame(&mut load, 110);
        assert_eq!(load.take(), None);
    }

    #[test]
    fn very_few_and_very_many_draws_are_bounded() {
        for (draws, planned) in [(1, 16), (1_000_000, 16_384)] {
            let mut load = DrawCount::default();
            (0..=STEADY_FRAMES as u64).for_each(|frame| load.end_frame((frame + 1) * draws));
            assert_eq!(load.take(), Some(planned));
        }
    }
}
