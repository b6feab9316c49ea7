//! Finds programs in which no draw is recognised as a scene.

use crate::intercept::process::log;
use crate::runtime::Session;

/// Number of draws after which the message is logged.
const ENOUGH: u64 = 300;

/// What a program draws to its own images.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OffScreen {
    /// Nothing.
    Nothing,
    /// Flat draws only.
    Flat,
    /// A scene that is not drawn for each view, with the reason.
    Scene(Option<String>),
}

/// Reports once that all draws to a window are flat, and what the user can try.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlatProgram {
    decided: bool,
}

impl FlatProgram {
    /// Examines the program at the end of a frame. `draws`: number of its draws to the window.
    /// `has_scene`: a part of a scene has been drawn there. `off_screen` returns what the program
    /// draws off screen.
    pub fn look(&mut self, draws: u64, has_scene: bool, session: &Session, off_screen: impl FnOnce() -> OffScreen) {
        if !self.is_flat(draws, has_scene) {
            return;
        }
        let off_screen = off_screen();
        if session.given_lens().is_some() && !matches!(off_screen, OffScreen::Scene(_)) {
            return;
        }
        let shows_own_lens = (0..session.views().len()).all(|index| session.tile(index).1);
        if !shows_own_lens {
            log::once(&match off_screen {
                OffScreen::Scene(Some(reason)) => {
                    format!(
                        "the program's scene is shown flat. It is drawn to an image first, and not to each view: {reason}"
                    )
                }
                OffScreen::Scene(None) => {
                    "the program's scene is shown flat. It is drawn to an image first, from which \
                     nothing seems to reach the window; try --duplicate always (docs/compatibility.md)"
                        .to_owned()
                }
                OffScreen::Flat | OffScreen::Nothing => {
                    let where_to = if matches!(off_screen, OffScreen::Flat) {
                        "to this window and to images"
                    } else {
                        "to this window"
                    };
                    format!(
                        "nothing that was drawn {where_to} so far has a matrix with a perspective: it is shown flat. If it \
                         is a scene, set camera.lens in the rig to the program's field of view (docs/compatibility.md)"
                    )
                }
            });
        }
    }

    /// True if the program has drawn enough, and no scene. The answer is true at most once.
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
