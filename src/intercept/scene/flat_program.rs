//! A program of which nothing is taken for a scene.

use crate::intercept::log;
use crate::runtime::Session;

/// Number of draws after which it is told so.
const ENOUGH: u64 = 300;

/// Says once that all draws to a window are flat, and what to try.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlatProgram {
    decided: bool,
}

impl FlatProgram {
    /// Looks at the program at the end of a frame: `draws` of it to the window, whether one of them was of a scene, and
    /// whether it draws `off_screen` first.
    pub fn look(&mut self, draws: u64, has_scene: bool, off_screen: bool, session: &Session) {
        if !self.is_flat(draws, has_scene) || session.given_lens().is_some() {
            return;
        }
        let shows_own_lens = (0..session.views().len()).all(|index| session.tile(index).1);
        if !shows_own_lens {
            let next = if off_screen {
                "The program draws to images of its own first: the statistics (--stats) say which of them are not drawn \
                 for each view, and why"
            } else {
                "If it is a scene, set camera.lens in the rig to the program's field of view (docs/compatibility.md)"
            };
            log::once(&format!(
                "nothing that was drawn to this window so far has a matrix with a perspective: it is shown flat. {next}"
            ));
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
