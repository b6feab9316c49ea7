//! A program that does not draw what lies beside its own field of view.

use crate::intercept::lens::field_of_view;
use crate::intercept::log;
use crate::runtime::Session;
use crate::runtime::session::Intrinsics;

/// Draws of a scene, by their place in the program's own picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Places {
    /// Those that are partly in it, and ahead of the eye.
    pub crossing: u64,
    /// Those that are wholly beside it, or behind the eye.
    pub outside: u64,
}

/// Draws at the border of the picture after which it is decided.
const ENOUGH: u64 = 300;

/// A program that leaves out what it does not see has so many times as many draws at the border as beside it: it leaves
/// out larger boxes or spheres than ours.
const FACTOR: u64 = 4;

/// Says once that objects are missing beside the program's own field of view.
#[derive(Clone, Copy, Debug, Default)]
pub struct CullingProgram {
    decided: bool,
}

impl CullingProgram {
    /// Looks at the program at the end of a frame.
    pub fn look(&mut self, places: Places, lens: Option<&Intrinsics>, session: &Session) {
        let shows_own_lens = (0..session.views().len()).all(|index| session.tile(index).1);
        if let (true, Some(lens), false) = (self.leaves_out(places), lens, shows_own_lens) {
            log::once(&format!(
                "the program seems to leave out what lies beside its own field of view ({}): of its draws {} cross the \
                 border of its picture, and {} lie beside it. Objects may be missing at the sides and behind. Give the \
                 program a larger field of view (docs/compatibility.md, \"What a program leaves out itself\")",
                field_of_view(lens),
                places.crossing,
                places.outside
            ));
        }
    }

    /// Whether it needs no more draws.
    pub fn is_decided(&self) -> bool {
        self.decided
    }

    /// Whether the program has drawn enough, and nothing beside its picture. It is asked until it has drawn enough.
    fn leaves_out(&mut self, places: Places) -> bool {
        let enough = places.crossing.max(places.outside) >= ENOUGH;
        let first = enough && !self.decided;
        self.decided |= enough;
        first && places.outside * FACTOR < places.crossing
    }
}

#[cfg(test)]
mod tests {
    use super::{CullingProgram, ENOUGH, Places};

    #[test]
    fn a_program_that_leaves_out_what_is_beside_is_told_once() {
        let mut program = CullingProgram::default();
        let places = |crossing, outside| Places { crossing, outside };
        assert!(!program.leaves_out(places(ENOUGH - 1, 0)), "that may be chance");
        assert!(program.leaves_out(places(ENOUGH, ENOUGH / 5)));
        assert!(!program.leaves_out(places(2 * ENOUGH, 0)), "it was told");
    }

    #[test]
    fn programs_that_draw_all_around_or_only_ahead_are_not_told() {
        let mut around = CullingProgram::default();
        assert!(!around.leaves_out(Places { crossing: ENOUGH / 3, outside: ENOUGH }));
        assert!(!around.leaves_out(Places { crossing: 9 * ENOUGH, outside: ENOUGH }), "it was decided");
        let mut ahead = CullingProgram::default();
        assert!((0..10_000).all(|_| !ahead.leaves_out(Places::default())));
    }
}
