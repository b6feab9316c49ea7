//! Draws that a view cannot show are left out of it, and no pixel changes by that.

use crate::compare::expect_identical;
use crate::programs::Run;

/// The same picture to the byte, with and without; the statistics of the run with.
fn same_picture(program: &str, rig: &str) -> Option<serde_json::Value> {
    same(Run::new(program), rig)
}

/// As [`same_picture`], for a run.
fn same(with: Run, rig: &str) -> Option<serde_json::Value> {
    let program = [with.program, " ", &with.extra.join(" ")].concat();
    let without = Run { cupola: &["--no-cull"], ..with.clone() };
    let [with, without] = [with.under(rig)?, without.under(rig)?].map(|f| f.expect_success().expect_no_gl_errors());
    let (counts, all) = (with.statistics(), without.statistics());
    assert_eq!(all["batches_left_out"], 0, "{program}: --no-cull leaves out batches");
    for view in all["views"].as_array().expect("views") {
        assert_eq!(view["draws_culled"], 0, "{program}: --no-cull leaves out draws");
    }
    if with.wrote("capture.png") {
        let what = format!("{program} {rig}, culled");
        expect_identical(&with.picture("capture.png"), &without.picture("capture.png"), &what);
    }
    Some(counts)
}

#[test]
fn pictures_stay_what_they_are() {
    let programs = ["immediate", "display_list", "client_arrays", "glsl120", "core330_mvp", "draws", "rectangles"];
    for program in programs.into_iter().chain([
        "hud",
        "text",
        "state",
        "occlusion",
        "feedback",
        "gles3",
        "post_process",
        "immediate_ways",
    ]) {
        same_picture(program, "fisheye");
    }
}

#[test]
fn views_to_the_sides_get_nothing_of_what_is_ahead() {
    // What is in buffers is known from the second frame on, so that the first draws to all views.
    for (program, frames) in [("ahead", 0), ("fixed_buffers", 1), ("buffers", 1)] {
        let run = Run { frames: 4, cupola_frames: 4, ..Run::new(program) };
        let Some(counts) = same(run.clone(), "fisheye-210") else { return };
        let Some(front) = same(run, "fisheye") else { return };
        nothing_at_the_sides(&[counts, front], frames, 4);
    }
}

/// In all but the first `unknown` of `frames` frames, some views get nothing.
fn nothing_at_the_sides(counts: &[serde_json::Value], unknown: u64, frames: u64) {
    for counts in counts {
        let views = counts["views"].as_array().expect("views");
        let number = |view: &serde_json::Value, key: &str| view[key].as_u64().expect("a number");
        let seen = counts["draws_seen"].as_u64().expect("a number");
        assert!(views.iter().any(|v| number(v, "draws_issued") > 0), "{counts:#}");
        let left_out = counts["batches_left_out"].as_u64().expect("a number");
        assert!(left_out > 0, "views that hold nothing were corrected: {counts:#}");
        let each = seen / frames;
        let empty = views.iter().filter(|v| number(v, "draws_issued") == unknown * each);
        assert!(empty.clone().count() >= 1, "{counts:#}");
        for view in empty {
            assert_eq!(number(view, "draws_culled"), seen - unknown * each, "{counts:#}");
        }
    }
}

/// Once it is known that a frame has few draws, another view costs less than what straddles two: five upright ones.
#[test]
fn a_program_of_few_draws_gets_the_views_that_suit_it() {
    let run = |frames: usize| Run { frames, cupola_frames: frames, ..Run::new("ahead") };
    let names = |counts: &serde_json::Value| -> Vec<String> {
        let views = counts["views"].as_array().expect("views").iter();
        views.map(|view| view["name"].as_str().expect("a name").to_owned()).collect()
    };
    let Some(early) = same(run(4), "fisheye") else { return };
    let late = same(run(16), "fisheye").expect("there is a display");
    assert_eq!((names(&early).len(), names(&late).len()), (4, 5), "{late:#}");
    let issued: Vec<u64> = late["views"]
        .as_array()
        .expect("views")
        .iter()
        .map(|v| v["draws_issued"].as_u64().expect("a number"))
        .collect();
    // One view shows it all; the last one gets the list behind the eye, because it sets a colour.
    assert_eq!(issued.iter().filter(|n| **n == 0).count(), 3, "{late:#}");
    // A rig that says what it favours keeps its views.
    let rig = concat!(env!("CARGO_TARGET_TMPDIR"), "/favour.toml");
    let text = "[views]\nfavour = \"cpu\"\n[dome]\ntilt = 90\n[[output]]\nkind = \"domemaster\"\ntilt = 90\n";
    std::fs::write(rig, text).expect("can be written");
    assert_eq!(names(&same(run(16), rig).expect("there is a display")).len(), 4);
}

#[test]
fn state_that_a_draw_leaves_survives_being_left_out() {
    let run = Run::new("ahead");
    let Some(plain) = run.plain() else { return };
    plain.expect_success();
    let run = Run { cupola_frames: run.frames + 1, ..run };
    if let Some(finished) = run.under("fisheye") {
        finished.expect_success();
    }
}

/// Ways in which what is in a buffer, or which buffer is drawn, can change.
const CHANGES: [&str; 16] = [
    "sub_data",
    "data",
    "named_sub_data",
    "copy",
    "named_copy",
    "map",
    "map_range",
    "clear",
    "compute",
    "indices",
    "pointer",
    "binding",
    "recreated",
    "feedback",
    "block",
    "block_bound",
];

#[test]
fn what_changes_in_a_buffer_is_seen() {
    let run = |mode: &'static [&'static str]| Run { frames: 6, cupola_frames: 6, extra: mode, ..Run::new("buffers") };
    let Some(still) = run(&[]).under("fisheye") else { return };
    let still = still.expect_success().picture("capture.png");
    let arguments: Vec<[&'static str; 2]> = CHANGES.iter().map(|mode| ["--mode", *mode]).collect();
    for mode in &*arguments.leak() {
        let Some(counts) = same(run(mode), "fisheye") else { return };
        assert!(counts["bounded_draws"].as_u64() > Some(0), "{mode:?}: {counts:#}");
        // The change can be seen at all.
        let changed = run(mode).under("fisheye").expect("there is a display").expect_success().picture("capture.png");
        assert!(changed.difference(&still).0 > 100, "{mode:?} changes nothing");
    }
    let Some(kept) = same(run(&["--mode", "kept"]), "fisheye") else { return };
    assert!(kept["bounded_draws"].as_u64() > Some(0), "{kept:#}");
}

#[test]
fn positions_of_every_form_are_where_they_are_drawn() {
    for rig in ["fisheye", "planetarium-6"] {
        let Some(counts) = same(Run { frames: 4, cupola_frames: 4, ..Run::new("positions") }, rig) else { return };
        let number = |key: &str| counts[key].as_u64().expect("a number");
        // Not followed are the ring with a fourth coordinate, the one that restarts its strip, and the four whose shader
        // moves them; in the first of four frames none is.
        assert_eq!(number("bounded_draws"), number("draws_seen") / 4 * 3 * 11 / 17, "{counts:#}");
        let views = counts["views"].as_array().expect("views").iter();
        let culled: u64 = views.map(|view| view["draws_culled"].as_u64().expect("a number")).sum();
        assert!(culled > number("bounded_draws"), "{counts:#}");
    }
}
