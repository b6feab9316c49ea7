//! Programs that judge themselves: OpenGL must answer them as it does without Cupola.

use crate::programs::Run;

fn judges_itself(program: &str, frames: usize) {
    let run = Run { frames, ..Run::new(program) };
    let Some(plain) = run.plain() else { return };
    plain.expect_success();
    for rig in ["identity", "identity-captured", "fisheye", "planetarium-6"] {
        // Cupola ends a program with status 0; here the program must come to its own end and verdict.
        let run = Run { cupola_frames: frames + 1, ..run.clone() };
        if let Some(finished) = run.under(rig) {
            finished.expect_success();
        }
    }
}

macro_rules! behaviour {
    ($($name:ident: $frames:literal),* $(,)?) => {
        $(#[test]
        fn $name() {
            judges_itself(stringify!($name), $frames);
        })*
    };
}

behaviour! {
    two_windows: 3,
    resize: 5,
    hud: 3,
    read_back: 4,
    multisample: 3,
    scissor: 3,
    text: 3,
    occlusion: 3,
    counting: 4,
    picking: 3,
    state: 4,
}
