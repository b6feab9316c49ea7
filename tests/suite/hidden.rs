//! Work that cannot be seen is left out, and no pixel of an output changes. Texels that no output
//! samples are closed for drawing. Windows that are not visible on the display are not corrected.

use crate::compare::{expect_identical, expect_identical_captures};
use crate::harness::tests;
use crate::programs::Run;

tests! {
    pictures_of_all_dialects_stay_what_they_are,
    pictures_of_programs_with_odd_state_stay_what_they_are,
    several_outputs_and_views_that_overlap_stay_what_they_are,
    windows_that_are_not_on_the_screen_are_not_corrected,
    a_capture_of_a_window_that_is_not_on_the_screen_is_corrected,
}

/// Checks that the picture is the same to the byte with and without the mask. Returns the
/// statistics of the run with the mask.
fn same_picture(program: &str, rig: &str) -> Option<serde_json::Value> {
    // Large enough to have a large unsampled area.
    same_picture_of((480, 480), program, rig)
}

fn same_picture_of(size: (usize, usize), program: &str, rig: &str) -> Option<serde_json::Value> {
    let with = Run { size, environment: &[("CUPOLA_MASK", "1")], ..Run::new(program) };
    let without = Run { cupola: &["--no-mask"], environment: &[], ..with.clone() };
    let [with, without] = [with.under(rig)?, without.under(rig)?].map(|f| f.expect_success().expect_no_gl_errors());
    let (counts, all) = (with.statistics(), without.statistics());
    assert_eq!(all["closings"], 0, "{program}: --no-mask closes texels");
    let what = format!("{program} {rig}, what is hidden closed");
    expect_identical_captures(&with, &without, &what);
    Some(counts)
}

fn pictures_of_all_dialects_stay_what_they_are() {
    let dialects = ["immediate", "display_list", "client_arrays", "glsl120", "core330_p_mv", "core330_mvp"];
    let more = ["core330_block", "geometry", "tessellation", "gles2", "gles3", "separable", "cube_dlopen"];
    for program in dialects.into_iter().chain(more) {
        let Some(counts) = same_picture(program, "fisheye") else { return };
        assert!(counts["closings"].as_u64() >= Some(2), "{program}: {counts:#}");
        let views = counts["views"].as_array().expect("views");
        assert!(views.iter().any(|view| view["closed_texels"].as_u64() > Some(10_000)), "{program}: {counts:#}");
    }
}

/// Programs with odd state, with the least number of times that their window is closed. Each draws
/// three frames.
const ODD: [(&str, u64); 14] = [
    ("hud", 3),
    ("text", 3),
    // It clears the window within a scissor only.
    ("state", 0),
    ("occlusion", 3),
    ("feedback", 3),
    ("multisample", 3),
    // It clears framebuffers of its own only.
    ("post_process", 0),
    ("scissor", 3),
    ("conditional", 3),
    ("direct_state", 3),
    ("rectangles", 3),
    ("resize", 3),
    ("two_windows", 6),
    ("attribute_stack", 3),
];

fn pictures_of_programs_with_odd_state_stay_what_they_are() {
    for (program, least) in ODD {
        let Some(counts) = same_picture(program, "fisheye") else { return };
        let closings = counts["closings"].as_u64().expect("a number");
        let right = if least == 0 { closings == 0 } else { closings >= least };
        assert!(right, "{program} is closed {closings} times, expected are {least}: {counts:#}");
    }
}

fn several_outputs_and_views_that_overlap_stay_what_they_are() {
    for program in ["core330_mvp", "immediate"] {
        let Some(counts) = same_picture_of((1200, 480), program, "planetarium-6") else { return };
        assert!(counts["closings"].as_u64() >= Some(2), "{program}: {counts:#}");
    }
}

fn windows_that_are_not_on_the_screen_are_not_corrected() {
    let after = |frames: usize| Run { frames, cupola_frames: frames, ..Run::new("unmapped") }.under("fisheye");
    let (Some(before), Some(back)) = (after(2), after(9)) else { return };
    let [before, back] = [before, back].map(|finished| finished.expect_success().expect_no_gl_errors());
    // The first swap after the window was unmapped detects it.
    let count = |finished: &crate::programs::Finished| finished.statistics()["hidden_frames"].as_u64();
    assert!(matches!(count(&back), Some(3..=4)), "{:?}", count(&back));
    assert_eq!(count(&before), Some(0));
    expect_identical(&back.picture("capture.png"), &before.picture("capture.png"), "a window that came back");
}

fn a_capture_of_a_window_that_is_not_on_the_screen_is_corrected() {
    let frames = |frames| Run { frames, cupola_frames: frames, ..Run::new("unmapped") };
    let (Some(hidden), Some(seen)) = (frames(5).under("fisheye"), frames(9).under("fisheye")) else { return };
    let [hidden, seen] = [hidden, seen].map(|finished| finished.expect_success().picture("capture.png"));
    expect_identical(&hidden, &seen, "the last frame, which is captured");
}
