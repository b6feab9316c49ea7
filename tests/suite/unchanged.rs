//! Frames in which nothing changed show the picture of the one before; others never do.

use crate::compare::expect_identical;
use crate::programs::{Finished, Run};

/// From this frame on the programs change something.
const CHANGES: u64 = 24;

/// The picture of a frame some way behind that, at which the program ends.
fn run(program: &str, mode: &str, cupola: &[&str]) -> Option<Finished> {
    let extra = ["--mode", mode];
    let run = Run { size: (200, 200), frames: 40, cupola_frames: 30, extra: &extra, cupola, ..Run::new(program) };
    Some(run.under("fisheye")?.expect_success().expect_no_gl_errors())
}

/// In each of `modes` the picture is the one that is corrected in every frame, to the byte, and another than without the
/// change. `frames` before the change show the picture of the one before: some, or none where something changes in every frame.
fn follows(program: &str, modes: &[&str], frames: std::ops::RangeInclusive<u64>) {
    let Some(still) = run(program, "still", &["--no-reuse"]) else { return };
    let still = still.picture("capture.png");
    for mode in modes {
        let [with, without] = [&[][..], &["--no-reuse"]].map(|cupola| run(program, mode, cupola).expect("a display"));
        let what = format!("{program} {mode}");
        let picture = with.picture("capture.png");
        expect_identical(&picture, &without.picture("capture.png"), &what);
        assert!(picture.difference(&still).1 > 8, "{what} changes nothing that can be seen");
        let (counts, all) = (with.statistics(), without.statistics());
        assert_eq!(all["reused_frames"], 0, "{what}: --no-reuse");
        let reused = counts["reused_frames"].as_u64().expect("a number");
        assert!(frames.contains(&reused), "{what}: {reused} frames, {}", counts["changed_by"]);
    }
}

/// Some of the frames before the change, and of those after it none or one.
const BEFORE: std::ops::RangeInclusive<u64> = 8..=CHANGES - 4;
const NEVER: std::ops::RangeInclusive<u64> = 0..=0;

#[test]
fn a_scene_that_stands_still_is_corrected_once() {
    for program in ["still", "still_shaders", "core330_mvp", "immediate", "gles3", "draws", "tessellation"] {
        let reuse = |cupola: &'static [&'static str]| {
            let run = Run { size: (200, 200), frames: 30, cupola_frames: 30, cupola, ..Run::new(program) };
            Some(run.under("fisheye")?.expect_success().expect_no_gl_errors())
        };
        let Some(with) = reuse(&[]) else { return };
        let without = reuse(&["--no-reuse"]).expect("a display");
        expect_identical(&with.picture("capture.png"), &without.picture("capture.png"), program);
        let counts = with.statistics();
        // The first frames find out what is drawn; views are planned anew once.
        assert!(counts["reused_frames"].as_u64() >= Some(12), "{program}: {}", counts["changed_by"]);
    }
}

/// A program that swaps without drawing.
#[test]
fn a_frame_without_a_call_is_the_one_before() {
    let Some(with) = run("still", "idle", &[]) else { return };
    let without = run("still", "idle", &["--no-reuse"]).expect("a display");
    expect_identical(&with.picture("capture.png"), &without.picture("capture.png"), "idle");
    let counts = with.statistics();
    assert!(counts["reused_frames"].as_u64() >= Some(20), "{}", counts["changed_by"]);
}

#[test]
fn state_of_the_fixed_function_pipeline_is_followed() {
    let state = ["alpha", "blending", "clear_colour", "clip_plane", "colour", "depth_function", "environment"];
    follows("still", &state, BEFORE);
    let state = ["filter", "fog", "fog_end", "light", "line_width", "mask", "material", "polygon_mode", "shade_model"];
    follows("still", &state, BEFORE);
}

#[test]
fn geometry_textures_and_lists_are_followed() {
    let modes = ["list", "list_base", "names", "stipple", "texels", "turned", "vertex", "left_colour"];
    follows("still", &modes, BEFORE);
}

#[test]
fn what_follows_from_the_last_frame_is_followed() {
    follows("still", &["drawn_over", "partly_cleared", "rotated_on"], BEFORE);
    follows("still", &["client_array", "copied_back", "scrolled_on", "stencil"], NEVER);
    follows("still_shaders", &["counted", "in_turns", "painted_over", "persistent", "stored"], NEVER);
}

#[test]
fn buffers_are_followed() {
    let modes = ["block", "copied", "data", "indices", "indirect", "mapped", "named_block", "sub_data"];
    follows("still_shaders", &modes, BEFORE);
}

#[test]
fn uniforms_draws_and_textures_are_followed() {
    let modes = ["attribute", "count", "one_more", "program_uniform", "several", "uniform", "uniforms"];
    follows("still_shaders", &modes, BEFORE);
    follows("still_shaders", &["named_texels", "off_screen", "sampler", "texels", "texture"], BEFORE);
}

#[test]
fn other_contexts_are_followed() {
    follows("still_shaders", &["other_context", "other_thread"], BEFORE);
}

/// What is kept is compared with what is corrected anew, frame by frame, in programs that do all kinds of things.
#[test]
fn no_frame_differs_from_the_picture_that_is_kept() {
    let mut reused = 0;
    for program in ["hud", "state", "text", "passes", "post_process", "requests", "positions", "own_names", "scissor"] {
        let run = Run { size: (200, 200), frames: 30, cupola_frames: 30, ..Run::new(program) };
        let checked = Run { environment: &[("CUPOLA_REUSE", "check")], ..run.clone() };
        let Some(checked) = checked.under("fisheye") else { return };
        let words = checked.words().into_owned();
        assert!(!words.contains("was held for the one before"), "{program}: {words}");
        reused += run.under("fisheye").expect("a display").statistics()["reused_frames"].as_u64().expect("a number");
    }
    assert!(reused > 0, "none of these programs stands still");
}
