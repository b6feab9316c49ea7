//! Views in turn: each frame of the program draws one view.

use crate::compare::{RESAMPLED, compare, expect_alike, expect_good, expect_identical};
use crate::dialects::{CAMERAS, camera_of, planetarium_of, shown_by_fisheye};
use crate::harness::tests;
use crate::programs::{Finished, Run};
use crate::reference::Fisheye;

tests! {
    what_cannot_be_followed_is_right,
    passes_and_matrices_are_those_of_the_view,
    six_projectors,
    flat_drawing_is_shown_once,
    a_round_is_one_frame,
    the_programs_own_picture_is_left_alone,
}

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
const IN_TURN: &[&str] = &["--duplicate", "in-turn"];

fn run<'a>(program: &'a str, extra: &'a [&'a str], cupola: &'a [&'a str]) -> Run<'a> {
    let (fov, yaw, pitch) = CAMERAS[1];
    // The plan has four views, so each frame on the dome needs four frames of the program.
    Run { fov, yaw, pitch, extra, cupola, frames: 100, cupola_frames: 6, ..Run::new(program) }
}

fn finished(run: &Run, rig: &str) -> Option<Finished> {
    Some(run.under(rig)?.expect_success().expect_no_gl_errors())
}

/// The program shows the predicted picture.
fn right(program: &str, mode: &str) {
    let extra = ["--mode", mode];
    let run = run(program, &extra, IN_TURN);
    let Some(under) = finished(&run, "fisheye") else { return };
    let picture = under.picture("capture.png");
    let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
    expect_good(&report, &picture, &format!("{program} {mode} in turn"));
}

/// Compute shaders that make pictures together with images of three dimensions or with sums. With
/// copies per view these pictures are flat.
fn what_cannot_be_followed_is_right() {
    right("computed", "volume");
    right("computed", "gathered");
    let extra = ["--mode", "volume"];
    let run = run("computed", &extra, &[]);
    let Some(flat) = finished(&run, "fisheye") else { return };
    let picture = flat.picture("capture.png");
    let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
    assert!(!report.good(), "the comparison finds nothing wrong with a flat picture");
}

/// Blits, copies from the window, depth, samples and several passes. Also skies and lights that are
/// computed from depth, in compute shaders, too.
fn passes_and_matrices_are_those_of_the_view() {
    for mode in ["light", "samples", "copied_window", "blit", "depth"] {
        right("passes", mode);
    }
    for mode in ["sky_off", "sky_vertices", "light_all", "place_all"] {
        right("camera_matrices", mode);
    }
    right("computed", "light");
}

fn six_projectors() {
    planetarium_of("passes", &["--mode", "light"], |run, rig| {
        finished(&Run { cupola: IN_TURN, frames: 100, ..run.clone() }, rig)
    });
}

/// Squares over the scene are at the same places as if all views were drawn in each frame.
fn flat_drawing_is_shown_once() {
    let all = run("hud", &[], &[]);
    let turns = run("hud", &[], IN_TURN);
    let (Some(all), Some(turns)) = (finished(&all, "fisheye"), finished(&turns, "fisheye")) else { return };
    // With views in turn each view has the window's size, and otherwise another size.
    expect_alike(&turns.picture("capture.png"), &all.picture("capture.png"), RESAMPLED, "flat drawing in turn");
}

/// A frame on the dome takes as many frames of the program as there are views. With `warm_up` it
/// takes more.
fn a_round_is_one_frame() {
    let extra = ["--mode", "light"];
    let counts = |cupola: &[&str]| -> Option<(u64, u64, u64)> {
        let statistics = finished(&run("passes", &extra, cupola), "fisheye")?.statistics();
        let number = |key: &str| statistics[key].as_u64().expect("a number");
        Some((number("frames"), number("draws_seen"), statistics["views"].as_array().expect("views").len() as u64))
    };
    let (Some(all), Some(turns)) = (counts(&[]), counts(IN_TURN)) else { return };
    assert_eq!((all.0, turns.0), (6, 6));
    assert_eq!(turns.1, all.1 * turns.2, "draws to the window in all turns");
}

/// If the program's own view is the rig's only view, there are no views to draw in turn.
fn the_programs_own_picture_is_left_alone() {
    let extra = ["--mode", "sampled", "--shot", "shot.ppm"];
    let run = Run { extra: &extra, cupola: IN_TURN, frames: 6, cupola_frames: 6, ..Run::new("computed") };
    let (Some(plain), Some(under)) = (run.plain(), run.under("identity-captured")) else { return };
    let (plain, under) = (plain.expect_success(), under.expect_success().expect_no_gl_errors());
    expect_identical(&under.picture("shot.ppm"), &plain.picture("shot.ppm"), "identity-captured");
}
