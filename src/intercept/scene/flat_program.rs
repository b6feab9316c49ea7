//! A program of which nothing is taken for a scene.

use crate::intercept::log;
use crate::runtime::Session;

/// Number of draws after which it is told so.
const ENOUGH: u64 = 300;

/// Says once that all draws of a program are flat, and what to try.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlatProgram {
    decided: bool,
}

impl FlatProgram {
    /// Looks at the program at the end of a frame: `draws` of it to the window, and whether one of them was of a scene.
    pub fn look(&mut self, draws: u64, has_scene: bool, session: &Session) {
        let shows_own_lens = (0..session.views().len()).all(|index| session.tile(index).1);
        if self.is_flat(draws, has_scene) && !shows_own_lens && session.given_lens().is_none() {
            log::once(
                "nothing that the program drew so far is a scene, because no matrix with a perspective was found in it: \
                 it is shown flat. If it is a scene, set camera.lens in the rig to the program's field of view \
                 (docs/compatibility.md)",
            );
        }
    }

    /// Whether the program has drawn enough, and nothing of a scene. It is asked until it has drawn enough, or a scene.
    fn is_flat(&mut self, draws: u64, has_scene: bool) -> bool {
        let flat = !self.decided && !has_scene && draws >= ENOUGH;
        self.decided |= has_scene || draws >= ENOUGH;
        flat
    }
}

#[cfg(test)]
mod tests {
    use super::{ENOUGH, FlatProgram};

    #[test]
    fn a_flat_program_is_told_once_and_one_with_a_scene_never() {
        let mut flat = FlatProgram::default();
        assert_eq!([ENOUGH - 1, ENOUGH, ENOUGH + 1].map(|draws| flat.is_flat(draws, false)), [false, true, false]);
        let mut scene = FlatProgram::default();
        assert!(!scene.is_flat(3, true) && !scene.is_flat(ENOUGH, true) && !scene.is_flat(2 * ENOUGH, false));
    }
}
