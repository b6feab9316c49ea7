//! Programs end as they do without Cupola, in whatever order the parts of the process are
//! destroyed.

use crate::compare::{compare, expect_good};
use crate::dialects::{camera_of, shown_by_fisheye};
use crate::harness::tests;
use crate::programs::{Finished, Run};
use crate::reference::Fisheye;

tests! {
    programs_end_as_they_would_by_themselves,
    programs_with_egl_end_as_they_would_by_themselves,
    a_program_that_unloads_opengl,
    a_picture_is_captured_though_it_is_never_swapped,
    a_signal_leaves_captures_and_statistics,
    a_program_ends_when_its_time_is_over,
}

/// Ways in which the program `ending` ends.
const WAYS: [&str; 12] = [
    "exit",
    "early",
    "late",
    "_exit",
    "abort",
    "terminate",
    "fault",
    "thread",
    "fork",
    "exec",
    "closed",
    "closed-current",
];

/// Exit status that a shell gives for a program that SIGSEGV ended.
const FAULT: i32 = 139;

fn end_alike(way: &str, windows: &[&str], rigs: &[&str]) {
    let extra: Vec<&str> = ["--mode", way].iter().chain(windows).copied().collect();
    // The program ends before the first swap, and after some swaps.
    for frames in [1, 3] {
        // Threads that continue to draw may draw many frames before the process ends.
        let cupola_frames = if way == "drawing" { 1_000_000 } else { frames + 1 };
        let run = Run { frames, extra: &extra, cupola_frames, ..Run::new("ending") };
        // With threads that continue to draw, Mesa alone ends 3 of 120 processes by SIGSEGV. Such a
        // run is repeated.
        let attempts = if way == "drawing" { 3 } else { 1 };
        let again = |start: &dyn Fn() -> Option<Finished>| {
            let mut finished = start();
            for _ in 1..attempts {
                finished = finished.and_then(|ended| if ended.status() == FAULT { start() } else { Some(ended) });
            }
            finished
        };
        let Some(plain) = again(&|| run.plain()) else { return };
        for rig in rigs {
            let Some(under) = again(&|| run.under(rig)) else { return };
            let what = format!("{way} {windows:?}, {frames} frames, {rig}:\n{}", under.words());
            assert_eq!(under.status(), plain.status(), "{what}");
            assert!(!under.words().contains("defect"), "{what}");
        }
    }
}

fn programs_end_as_they_would_by_themselves() {
    WAYS.into_iter().chain(["drawing"]).for_each(|way| end_alike(way, &[], &["identity-captured", "fisheye"]));
}

fn programs_with_egl_end_as_they_would_by_themselves() {
    WAYS.into_iter().for_each(|way| end_alike(way, &["--egl"], &["fisheye"]));
}

fn a_program_that_unloads_opengl() {
    let run = Run { extra: &["--close", "1"], cupola_frames: 0, ..Run::new("cube_dlopen") };
    let (Some(plain), Some(under)) = (run.plain(), run.under("fisheye")) else { return };
    plain.expect_success();
    under.expect_success();
}

/// The program ends during the frame that is to be captured.
fn a_picture_is_captured_though_it_is_never_swapped() {
    for way in ["exit", "early", "late", "thread"] {
        let extra = ["--mode", way];
        let run = Run { frames: 1, extra: &extra, cupola_frames: 1, ..Run::new("ending") };
        let Some(finished) = run.under("fisheye") else { return };
        assert_eq!(finished.status(), 7, "{way}: {}", finished.words());
        let picture = finished.expect_no_gl_errors().picture("capture.png");
        let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
        let report = compare(&picture, shown_by_fisheye(circle, camera_of(&run)));
        expect_good(&report, &picture, &format!("ending {way}"));
    }
}

/// A frame number that the program does not reach before it is ended.
const MANY_FRAMES: &[&str] = &["--frames", "1000000"];

/// Runs a program that is ended, and checks that its picture and its statistics exist.
fn expect_report(way: &str, options: &[&str], status: i32) {
    let extra = ["--mode", way];
    let run = Run { frames: 3, extra: &extra, cupola_frames: 0, cupola: options, ..Run::new("ending") };
    let Some(finished) = run.under("fisheye") else { return };
    let what = format!("{way}, {options:?}");
    assert_eq!(finished.status(), status, "{what}: {}", finished.words());
    let picture = finished.expect_no_gl_errors().picture("capture.png");
    let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
    expect_good(&compare(&picture, shown_by_fisheye(circle, camera_of(&run))), &picture, &what);
}

fn a_signal_leaves_captures_and_statistics() {
    for (way, signal) in [("terminate", libc::SIGTERM), ("abort", libc::SIGABRT), ("fault", libc::SIGSEGV)] {
        expect_report(way, &[], 128 + signal);
    }
    // The captured frame is the one that is drawn after the signal, or else the last one before it.
    expect_report("killed", MANY_FRAMES, 128 + libc::SIGTERM);
    expect_report("killed", &[], 128 + libc::SIGTERM);
    expect_report("killed-idle", &[], 128 + libc::SIGTERM);
}

fn a_program_ends_when_its_time_is_over() {
    expect_report("busy", &["--seconds", "0.5"], 0);
    expect_report("busy", &["--seconds", "0.5", MANY_FRAMES[0], MANY_FRAMES[1]], 0);
    // A program that draws no more frames is ended by a signal.
    expect_report("idle", &["--seconds", "0.5"], 0);
}
