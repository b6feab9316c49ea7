//! Programs that check OpenGL's answers themselves. The answers must be the same as without Cupola.

use crate::harness::tests;
use crate::programs::Run;

fn judges_itself(program: &str, frames: usize) {
    judges_itself_under(program, frames, &["identity", "identity-captured", "fisheye", "planetarium-6"]);
}

fn judges_itself_under(program: &str, frames: usize, rigs: &[&str]) {
    let run = Run { frames, ..Run::new(program) };
    let Some(plain) = run.plain() else { return };
    plain.expect_success();
    for rig in rigs {
        // At its last frame Cupola would end the program with status 0. This program must reach its
        // own end and its own verdict.
        let run = Run { cupola_frames: frames + 1, ..run.clone() };
        if let Some(finished) = run.under(rig) {
            finished.expect_success();
        }
    }
}

macro_rules! behaviour {
    ($($name:ident: $frames:literal),* $(,)?) => {
        tests![$($name),*, a_first_read_of_depth, a_read_of_one_pixel_is_cheap];

        $(fn $name() {
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
    query_buffer: 3,
    picking: 3,
    state: 4,
    flat_modes: 3,
    list_begin: 3,
    program_life: 5,
    own_choice: 3,
    flat_feedback: 3,
    window_errors: 3,
    gles2_query: 3,
    viewports: 3,
}

/// The projectors of a rig show less than the program's own picture. Where no view shows anything,
/// the depth must be that of an empty window. All other depths must be correct, too.
fn a_first_read_of_depth() {
    judges_itself_under("first_depth", 4, &["identity", "identity-captured", "fisheye"]);
    let run = Run { frames: 4, extra: &["--mode", "partial"], ..Run::new("first_depth") };
    let Some(plain) = run.plain() else { return };
    plain.expect_success();
    if let Some(finished) = (Run { cupola_frames: 5, ..run }).under("planetarium-6") {
        finished.expect_success();
    }
}

/// Reads single pixels in a large window, where a read of the whole window takes much longer.
fn a_read_of_one_pixel_is_cheap() {
    for samples in ["0", "4"] {
        let extra = ["--samples", samples];
        let run = Run { size: (1000, 1000), extra: &extra, ..Run::new("small_reads") };
        let Some(plain) = run.plain() else { return };
        plain.expect_success();
        for rig in ["identity-captured", "fisheye"] {
            let Some(finished) = Run { cupola_frames: 4, ..run.clone() }.under(rig) else { return };
            finished.expect_success();
        }
    }
}
