//! Draws that a view cannot show are left out of it, and no pixel changes by that.

use crate::compare::expect_identical;
use crate::programs::Run;

/// The same picture to the byte, with and without; the statistics of the run with.
fn same_picture(program: &str, rig: &str) -> Option<serde_json::Value> {
    let with = Run::new(program);
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
    let Some(counts) = same_picture("ahead", "fisheye-210") else { return };
    let Some(front) = same_picture("ahead", "fisheye") else { return };
    for counts in [counts, front] {
        let views = counts["views"].as_array().expect("views");
        let number = |view: &serde_json::Value, key: &str| view[key].as_u64().expect("a number");
        let seen = counts["draws_seen"].as_u64().expect("a number");
        assert!(views.iter().any(|v| number(v, "draws_issued") > 0), "{counts:#}");
        let left_out = counts["batches_left_out"].as_u64().expect("a number");
        assert!(left_out > 0, "views that hold nothing were corrected: {counts:#}");
        let empty = views.iter().filter(|v| number(v, "draws_issued") == 0);
        assert!(empty.clone().count() >= 1, "{counts:#}");
        for view in empty {
            assert_eq!(number(view, "draws_culled"), seen, "{counts:#}");
        }
    }
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
