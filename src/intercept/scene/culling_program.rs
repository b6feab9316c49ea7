//! Finds programs that do not draw objects outside their own field of view.

use crate::intercept::scene::lens::field_of_view;
use crate::runtime::Session;
use crate::runtime::session::Intrinsics;

/// Numbers of scene draws, by their position in the program's own picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Places {
    /// Draws that cross the border of the picture, in front of the camera.
    pub crossing: u64,
    /// Draws that are entirely beside the picture or behind the camera.
    pub outside: u64,
}

/// Number of draws at the border of the picture or beside it from which a frame counts. A single
/// large model proves nothing.
const ENOUGH: u64 = 12;

/// Number of frames that must give the same result.
const FRAMES: u32 = 10;

/// Number of frames after which the search ends, because it costs a little in each draw.
const MOST_FRAMES: u32 = 2000;

/// Ratio of draws at the border to draws beside it from which the program counts as culling. The
/// program's boxes or spheres are larger than Cupola's, so that it draws some objects beside the
/// picture.
const FACTOR: u64 = 4;

/// Tells once that objects outside the program's own field of view are missing.
#[derive(Clone, Copy, Debug, Default)]
pub struct CullingProgram {
    /// Draws of earlier frames.
    before: Places,
    /// Number of frames in which the program seemed to leave out something.
    frames: u32,
    /// Number of frames that were examined.
    looked_at: u32,
    decided: bool,
}

impl CullingProgram {
    /// Examines the draws at the end of a frame. Returns the message if it is to be logged now.
    /// `draws`: all of the program's draws so far.
    pub fn look(&mut self, draws: Places, lens: Option<&Intrinsics>, session: &Session) -> Option<String> {
        let shows_own_lens = (0..session.views().len()).all(|index| session.tile(index).1);
        let lens = lens.filter(|_| !shows_own_lens);
        self.leaves_out(draws).then_some(lens).flatten().map(|lens| {
            format!(
                "the program seems to leave out what lies beside its own field of view ({}): of its draws {} cross the \
                 border of its picture, and {} lie beside it. Objects may be missing at the sides and behind. Give the \
                 program a larger field of view (docs/compatibility.md, \"What a program leaves out itself\")",
                field_of_view(lens),
                draws.crossing,
                draws.outside
            )
        })
    }

    /// True if it needs no more draws.
    pub fn is_decided(&self) -> bool {
        self.decided
    }

    /// True if the program is found, in this frame, to leave out something.
    fn leaves_out(&mut self, draws: Places) -> bool {
        let crossing = draws.crossing - self.before.crossing;
        let outside = draws.outside - self.before.outside;
        self.before = draws;
        if self.decided {
            return false;
        }
        self.looked_at += 1;
        self.decided = self.looked_at >= MOST_FRAMES;
        if crossing.max(outside) < ENOUGH {
            return false;
        }
        let leaves_out = outside * FACTOR < crossing;
        self.frames += u32::from(leaves_out);
        let told = leaves_out && self.frames >= FRAMES;
        self.decided |= !leaves_out || told;
        told
    }
}

#[cfg(test)]
mod tests {
    use super::{CullingProgram, ENOUGH, FRAMES, MOST_FRAMES, Places};
    use crate::rig;
    use crate::runtime::session::{Extras, Intrinsics, Session};

    #[test]
    fn the_message_is_given_only_where_views_differ_from_the_program_s_picture() {
        let lens = Intrinsics { a: 1.0, b: 0.0, c: 1.0, d: 0.0, e: -1.02, f: Some(-0.2) };
        let messages = |preset: &str| {
            let rig = rig::load(preset).expect("a preset");
            let session = Session::new(&rig, (256, 256), false, 4096, Extras::default()).expect("can be planned");
            let mut program = CullingProgram::default();
            let frames = (1..=u64::from(2 * FRAMES)).map(|frame| Places { crossing: frame * ENOUGH, outside: 0 });
            frames.filter_map(|draws| program.look(draws, Some(&lens), &session)).collect::<Vec<_>>()
        };
        assert_eq!(messages("identity"), [""; 0]);
        let told = messages("fisheye");
        assert!(told.len() == 1 && told[0].contains("90.00° × 90.00°"), "{told:?}");
    }

    /// Returns in how many of these frames a program with these draws in each frame is reported.
    fn told(program: &mut CullingProgram, frames: u32, crossing: u64, outside: u64) -> usize {
        let Places { crossing: c, outside: o } = program.before;
        let after = |frame: u64| Places { crossing: c + frame * crossing, outside: o + frame * outside };
        (1..=u64::from(frames)).filter(|frame| program.leaves_out(after(*frame))).count()
    }

    #[test]
    fn a_program_that_leaves_out_what_is_beside_is_told_once() {
        let mut program = CullingProgram::default();
        assert_eq!(told(&mut program, FRAMES - 1, ENOUGH, ENOUGH / 5), 0, "that may be chance");
        assert_eq!(told(&mut program, 50, ENOUGH, ENOUGH / 5), 1);
    }

    #[test]
    fn programs_that_draw_all_around_or_only_ahead_are_not_told() {
        let mut around = CullingProgram::default();
        assert_eq!(told(&mut around, 1, ENOUGH / 3, ENOUGH), 0);
        assert!(around.is_decided() && told(&mut around, 100, 9 * ENOUGH, 0) == 0);
        assert_eq!(told(&mut CullingProgram::default(), 10_000, 0, 0), 0);
        // A large model.
        let mut large = CullingProgram::default();
        assert_eq!(told(&mut large, MOST_FRAMES - 1, ENOUGH - 1, 0), 0);
        assert!(!large.is_decided());
        assert_eq!(told(&mut large, 100, ENOUGH - 1, 0), 0);
        assert!(large.is_decided(), "it costs nothing any more");
    }
}
