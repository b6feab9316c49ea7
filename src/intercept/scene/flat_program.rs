//! Finds programs in which no draw is recognised as a scene.

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

/// Reason why a draw has no lens. Reasons that stand later hide a matrix, so they are likelier to
/// be those of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum MissingLens {
    /// Its shaders multiply its positions by no matrix.
    #[default]
    NoMatrix,
    /// Its matrices have no perspective.
    NoPerspective,
    /// It goes to a part of the window.
    PartOfWindow,
    /// Its positions come from storage buffers, and are multiplied by no matrix.
    Stored,
    /// Its shaders make a matrix of other numbers.
    Composed,
    /// Its matrix is in memory that the processor cannot read.
    OfDevice,
    /// Its matrix is in memory of which its shaders have only the address.
    Address,
    /// Its matrix is in a vertex attribute that cannot be read.
    Attribute,
}

impl MissingLens {
    /// The reason, as a sentence about several draws.
    pub fn reason(self) -> &'static str {
        match self {
            Self::NoMatrix => "their shaders multiply positions by no 4×4 matrix",
            Self::NoPerspective => "their matrices have no perspective",
            Self::PartOfWindow => "they go to a viewport that is smaller than the window",
            Self::Stored => "their positions come from storage buffers, where compute shaders may have computed them",
            Self::Composed => "their shaders make the matrix of other numbers",
            Self::OfDevice => {
                "their matrix is in memory that only the device can read, such as what it computes itself"
            }
            Self::Address => "their matrix is at an address that cannot be followed",
            Self::Attribute => "their matrix is in a vertex attribute that cannot be read",
        }
    }
}

/// Numbers of draws without a lens, by the reason. Counting allocates nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct MissingLenses([u64; 8]);

impl MissingLenses {
    /// Counts draws that have no lens for this reason.
    pub fn count(&mut self, reason: MissingLens, draws: u64) {
        self.0[reason as usize] += draws;
    }

    /// Text for the likeliest reason why there is no scene: the last one that has draws.
    fn likeliest(&self) -> String {
        use MissingLens as M;
        let hidden = [M::Stored, M::Composed, M::OfDevice, M::Address, M::Attribute];
        let reasons = [M::NoMatrix, M::NoPerspective, M::PartOfWindow].into_iter().chain(hidden);
        let all: u64 = self.0.iter().sum();
        let found = reasons.zip(self.0).filter(|(_, draws)| *draws > 0).last();
        let text = |(reason, draws): (M, u64)| format!(" In {draws} of {all} draws {}.", reason.reason());
        found.map(text).unwrap_or_default()
    }
}

/// Tells once that all draws to a window are flat, and what the user can try.
#[derive(Clone, Debug, Default)]
pub struct FlatProgram {
    decided: bool,
    note: Option<String>,
}

impl FlatProgram {
    /// Examines the program at the end of a frame. Returns the message if it is to be logged now.
    /// `draws`: number of its draws to the window.
    /// `has_scene`: a part of a scene has been drawn there. `missing`: draws without a lens, as far
    /// as they are known. `off_screen` returns what the program draws off screen.
    pub fn look(
        &mut self,
        draws: u64,
        has_scene: bool,
        session: &Session,
        missing: &MissingLenses,
        off_screen: impl FnOnce() -> OffScreen,
    ) -> Option<&str> {
        if !self.is_flat(draws, has_scene) {
            return None;
        }
        let off_screen = off_screen();
        if session.given_lens().is_some() && !matches!(off_screen, OffScreen::Scene(_)) {
            return None;
        }
        let shows_own_lens = (0..session.views().len()).all(|index| session.tile(index).1);
        (!shows_own_lens).then(|| &**self.note.insert(text(&off_screen, missing)))
    }

    /// The message, for the statistics.
    pub fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// True if the program has drawn enough, and no scene. The answer is true at most once.
    fn is_flat(&mut self, draws: u64, has_scene: bool) -> bool {
        let flat = !self.decided && !has_scene && draws >= ENOUGH;
        self.decided |= has_scene || draws >= ENOUGH;
        flat
    }
}

/// Message for a program without a scene.
fn text(off_screen: &OffScreen, missing: &MissingLenses) -> String {
    let where_to = match off_screen {
        OffScreen::Scene(Some(reason)) => {
            return format!(
                "the program's scene is shown flat. It is drawn to an image first, and not to each view: {reason}"
            );
        }
        OffScreen::Scene(None) => {
            return "the program's scene is shown flat. It is drawn to an image first, from which nothing seems to reach \
                    the window; try --duplicate always (docs/compatibility.md)"
                .to_owned();
        }
        OffScreen::Flat => "to this window and to images",
        OffScreen::Nothing => "to this window",
    };
    format!(
        "nothing that was drawn {where_to} so far has a matrix with a perspective: it is shown flat.{} If it is a scene, \
         set camera.lens in the rig to the program's field of view; if the program makes a fisheye itself, use --content \
         (docs/compatibility.md)",
        missing.likeliest()
    )
}

#[cfg(test)]
mod tests {
    use super::{ENOUGH, FlatProgram, MissingLens, MissingLenses, OffScreen, text};
    use crate::rig;
    use crate::runtime::session::{Extras, Session};

    fn session(preset: &str) -> Session {
        let rig = rig::load(preset).expect("a preset");
        Session::new(&rig, (256, 256), false, 4096, Extras::default()).expect("can be planned")
    }

    #[test]
    fn the_message_is_given_once_where_views_differ_from_the_program_s_picture() {
        let missing = MissingLenses::default();
        let look = |flat: &mut FlatProgram, session: &Session| {
            flat.look(ENOUGH, false, session, &missing, || OffScreen::Nothing).map(str::to_owned)
        };
        let mut flat = FlatProgram::default();
        let told = look(&mut flat, &session("fisheye")).expect("a message");
        assert_eq!(flat.note(), Some(&*told));
        assert_eq!(look(&mut flat, &session("fisheye")), None, "told already");
        let mut identity = FlatProgram::default();
        assert_eq!((look(&mut identity, &session("identity")), identity.note()), (None, None));
    }

    #[test]
    fn a_flat_program_is_told_once_and_one_with_a_scene_never() {
        let mut flat = FlatProgram::default();
        assert_eq!([ENOUGH - 1, ENOUGH, ENOUGH + 1].map(|draws| flat.is_flat(draws, false)), [false, true, false]);
        let mut scene = FlatProgram::default();
        assert!(!scene.is_flat(3, true) && !scene.is_flat(ENOUGH, true) && !scene.is_flat(2 * ENOUGH, false));
    }

    #[test]
    fn the_message_has_the_reason_that_hides_a_matrix() {
        let mut missing = MissingLenses::default();
        let all = [(MissingLens::NoPerspective, 290), (MissingLens::Address, 10), (MissingLens::NoMatrix, 1)];
        all.into_iter().for_each(|(reason, draws)| missing.count(reason, draws));
        let words = text(&OffScreen::Nothing, &missing);
        assert!(words.contains("In 10 of 301 draws their matrix is at an address"), "{words}");
        assert!(!text(&OffScreen::Flat, &MissingLenses::default()).contains(" draws "), "no reason is known");
    }
}
