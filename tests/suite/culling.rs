//! Draws that a view cannot show are left out of that view. No pixel changes.

use crate::compare::{expect_identical, expect_identical_captures};
use crate::harness::tests;
use crate::programs::{Run, scratch};

tests! {
    what_a_program_leaves_out_is_told,
    planes_that_a_program_asks_for_are_wide,
    pictures_stay_what_they_are,
    views_to_the_sides_get_nothing_of_what_is_ahead,
    a_program_of_few_draws_gets_the_views_that_suit_it,
    state_that_a_draw_leaves_survives_being_left_out,
    what_changes_in_a_buffer_is_seen,
    positions_of_every_form_are_where_they_are_drawn,
    views_to_the_sides_get_nothing_of_what_is_ahead_off_screen,
    what_opengl_answers_about_draws_off_screen_stays,
    pictures_that_are_drawn_off_screen_stay_what_they_are,
    random_scenes_off_screen_stay_what_they_are,
    what_is_read_of_an_image_is_whole,
}

/// Checks that the picture is the same to the byte with and without culling. Returns the statistics
/// of the run with culling.
fn same_picture(program: &str, rig: &str) -> Option<serde_json::Value> {
    same(Run::new(program), rig)
}

/// As [`same_picture`], for any run.
fn same(with: Run, rig: &str) -> Option<serde_json::Value> {
    let program = [with.program, " ", &with.extra.join(" ")].concat();
    let without = Run { cupola: &["--no-cull"], ..with.clone() };
    let [with, without] = [with.under(rig)?, without.under(rig)?].map(|f| f.expect_success().expect_no_gl_errors());
    let (counts, all) = (with.statistics(), without.statistics());
    assert_eq!(all["batches_left_out"], 0, "{program}: --no-cull leaves out batches");
    assert_eq!(all["outputs_narrowed"], 0, "{program}: --no-cull corrects parts of outputs");
    for view in all["views"].as_array().expect("views") {
        assert_eq!(view["draws_culled"], 0, "{program}: --no-cull leaves out draws");
    }
    let every = all["duplicated_draws"].as_u64().expect("a number");
    for [issued, culled] in off_screen(&all) {
        assert!(issued == every && culled == 0, "{program}: --no-cull leaves out draws off screen");
    }
    let what = format!("{program} {rig}, culled");
    expect_identical_captures(&with, &without, &what);
    Some(counts)
}

/// For each view the number of off-screen draws that it got, and the number that was left out.
fn off_screen(counts: &serde_json::Value) -> Vec<[u64; 2]> {
    let views = counts["views"].as_array().expect("views").iter();
    let number = |view: &serde_json::Value, key: &str| view[key].as_u64().expect("a number");
    views.map(|view| ["duplicated_draws_issued", "duplicated_draws_culled"].map(|key| number(view, key))).collect()
}

/// Number of draws that were left out of views, in the window and off screen.
fn culled(counts: &serde_json::Value) -> u64 {
    let views = counts["views"].as_array().expect("views").iter();
    let in_window: u64 = views.map(|view| view["draws_culled"].as_u64().expect("a number")).sum();
    in_window + off_screen(counts).iter().map(|[_, culled]| culled).sum::<u64>()
}

/// Checks that at least so many draws were left out, or none if `least` is 0.
fn expect_culled(counts: &serde_json::Value, least: u64, what: &str) {
    let culled = culled(counts);
    let right = if least == 0 { culled == 0 } else { culled >= least };
    assert!(right, "{what}: {culled} draws are left out, expected are {least}: {counts:#}");
}

/// Programs, with the least number of draws that are left out of views in three frames.
const LEFT_OUT: [(&str, u64); 15] = [
    ("immediate", 9),
    ("display_list", 21),
    ("occlusion", 18),
    ("immediate_ways", 12),
    // One draw shows all directions.
    ("client_arrays", 0),
    ("glsl120", 0),
    ("core330_mvp", 0),
    ("hud", 0),
    ("text", 0),
    ("state", 0),
    ("feedback", 0),
    ("gles3", 0),
    ("post_process", 0),
    // Its shader moves positions, so that bounds are not known.
    ("draws", 0),
    // Bounds of glRect are not known.
    ("rectangles", 0),
];

fn pictures_stay_what_they_are() {
    for (program, least) in LEFT_OUT {
        let Some(counts) = same_picture(program, "fisheye") else { return };
        expect_culled(&counts, least, program);
    }
}

fn views_to_the_sides_get_nothing_of_what_is_ahead() {
    // The content of buffers is known from the second frame on. The first frame draws to all views.
    for (program, frames) in [("ahead", 0), ("fixed_buffers", 1), ("buffers", 1)] {
        let run = Run { frames: 4, cupola_frames: 4, ..Run::new(program) };
        let Some(counts) = same(run.clone(), "fisheye-210") else { return };
        let Some(front) = same(run, "fisheye") else { return };
        nothing_at_the_sides(&[counts, front], frames, 4);
    }
}

/// Checks that some views get nothing in all but the first `unknown` of `frames` frames.
fn nothing_at_the_sides(counts: &[serde_json::Value], unknown: u64, frames: u64) {
    for counts in counts {
        let views = counts["views"].as_array().expect("views");
        let number = |view: &serde_json::Value, key: &str| view[key].as_u64().expect("a number");
        let seen = counts["draws_seen"].as_u64().expect("a number");
        assert!(views.iter().any(|v| number(v, "draws_issued") > 0), "{counts:#}");
        let left_out = counts["batches_left_out"].as_u64().expect("a number");
        assert!(left_out > 0, "empty views were corrected: {counts:#}");
        let narrowed = counts["outputs_narrowed"].as_u64().expect("a number");
        assert!(narrowed > 0, "the whole output was corrected: {counts:#}");
        let each = seen / frames;
        let empty = views.iter().filter(|v| number(v, "draws_issued") == unknown * each);
        assert!(empty.clone().count() >= 1, "{counts:#}");
        for view in empty {
            assert_eq!(number(view, "draws_culled"), seen - unknown * each, "{counts:#}");
        }
    }
}

/// Once a frame is known to have few draws, one more view costs less than draws that cross the
/// border of two views. The plan then has five upright views.
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
    // One view shows everything. The last view gets the list behind the viewer, because the list
    // sets a colour.
    assert_eq!(issued.iter().filter(|n| **n == 0).count(), 3, "{late:#}");
    // If the rig sets `favour`, the views stay.
    let rig = concat!(env!("CARGO_TARGET_TMPDIR"), "/favour.toml");
    let text = "[views]\nfavour = \"cpu\"\n[dome]\ntilt = 90\n[[output]]\nkind = \"domemaster\"\ntilt = 90\n";
    std::fs::write(rig, text).expect("can be written");
    assert_eq!(names(&same(run(16), rig).expect("there is a display")).len(), 4);
}

fn state_that_a_draw_leaves_survives_being_left_out() {
    let run = Run::new("ahead");
    let Some(plain) = run.plain() else { return };
    plain.expect_success();
    let run = Run { cupola_frames: run.frames + 1, ..run };
    if let Some(finished) = run.under("fisheye") {
        finished.expect_success();
    }
}

/// Ways to change the content of a buffer, or to change which buffer is drawn.
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

fn what_changes_in_a_buffer_is_seen() {
    let run = |mode: &'static [&'static str]| Run { frames: 6, cupola_frames: 6, extra: mode, ..Run::new("buffers") };
    let Some(still) = run(&[]).under("fisheye") else { return };
    let still = still.expect_success().picture("capture.png");
    let arguments: Vec<[&'static str; 2]> = CHANGES.iter().map(|mode| ["--mode", *mode]).collect();
    for mode in &*arguments.leak() {
        let Some(counts) = same(run(mode), "fisheye") else { return };
        assert!(counts["bounded_draws"].as_u64() > Some(0), "{mode:?}: {counts:#}");
        // Control: the change is visible.
        let changed = run(mode).under("fisheye").expect("there is a display").expect_success().picture("capture.png");
        assert!(changed.difference(&still).0 > 100, "{mode:?} changes nothing");
    }
    let Some(kept) = same(run(&["--mode", "kept"]), "fisheye") else { return };
    assert!(kept["bounded_draws"].as_u64() > Some(0), "{kept:#}");
}

fn positions_of_every_form_are_where_they_are_drawn() {
    for rig in ["fisheye", "planetarium-6"] {
        let Some(counts) = same(Run { frames: 4, cupola_frames: 4, ..Run::new("positions") }, rig) else { return };
        let number = |key: &str| counts[key].as_u64().expect("a number");
        // Bounds are not known for the ring with a fourth coordinate, for the one that restarts its
        // strip, and for the four whose shader moves them. In the first of four frames no bounds
        // are known.
        assert_eq!(number("bounded_draws"), number("draws_seen") / 4 * 3 * 11 / 17, "{counts:#}");
        assert!(culled(&counts) > number("bounded_draws"), "{counts:#}");
    }
}

/// The same for scenes that a program draws into framebuffers of its own and then shows.
fn views_to_the_sides_get_nothing_of_what_is_ahead_off_screen() {
    for program in ["ahead", "fixed_buffers"] {
        let run = Run { frames: 4, cupola_frames: 4, extra: &["--fbo"], ..Run::new(program) };
        for rig in ["fisheye-210", "fisheye"] {
            let Some(counts) = same(run.clone(), rig) else { return };
            let all = counts["duplicated_draws"].as_u64().expect("a number");
            let views = off_screen(&counts);
            assert!(all > 0 && views.iter().any(|[issued, _]| *issued > 0), "{program} {rig}: {counts:#}");
            assert!(views.contains(&[0, all]), "{program} {rig}: every view got draws: {counts:#}");
            assert!(views.iter().all(|[issued, culled]| issued + culled == all), "{program} {rig}: {counts:#}");
        }
    }
}

/// Queries of state and counts. The programs check the answers themselves.
fn what_opengl_answers_about_draws_off_screen_stays() {
    for (program, extra) in [
        ("ahead", ["--fbo"].as_slice()),
        ("occlusion", &["--fbo"]),
        ("counting", &["--fbo"]),
        ("scattered", &["--mode", "count"]),
    ] {
        let run = Run { frames: 4, cupola_frames: 5, extra, ..Run::new(program) };
        let Some(plain) = run.plain() else { return };
        plain.expect_success();
        if let Some(finished) = run.under("fisheye") {
            finished.expect_success();
        }
    }
}

/// Programs that draw off screen and their rig, with the least number of draws that are left out of
/// views in four frames.
const LEFT_OUT_OFF_SCREEN: [(&str, &str, u64); 9] = [
    ("positions", "fisheye", 909),
    ("positions", "planetarium-6", 1152),
    ("outlines", "fisheye", 375),
    ("immediate_ways", "fisheye", 12),
    ("counting", "fisheye", 12),
    ("occlusion", "fisheye", 18),
    // Bounds of glRect are not known.
    ("rectangles", "fisheye", 0),
    // One draw shows all directions.
    ("gles2", "fisheye", 0),
    ("gles3", "fisheye", 0),
];

fn pictures_that_are_drawn_off_screen_stay_what_they_are() {
    for (program, rig, least) in LEFT_OUT_OFF_SCREEN {
        let run = Run { frames: 4, cupola_frames: 4, extra: &["--fbo"], ..Run::new(program) };
        let Some(counts) = same(run, rig) else { return };
        expect_culled(&counts, least, &format!("{program} off screen, {rig}"));
    }
    // These programs show all directions in one draw.
    let Some(counts) = same(Run { extra: &["--samples", "4"], ..Run::new("post_process") }, "fisheye") else { return };
    expect_culled(&counts, 0, "post_process");
    for mode in ["resolve", "samples", "depth", "apart", "light", "twice", "bloom"] {
        let Some(counts) = same(Run { extra: &["--mode", mode], ..Run::new("passes") }, "fisheye") else { return };
        expect_culled(&counts, 0, mode);
    }
}

/// Objects in all directions, drawn with every kind of draw and shown in the window in every way.
fn random_scenes_off_screen_stay_what_they_are() {
    for mode in ["blit", "samples", "chain", "lamps", "ahead"] {
        for (seed, rig) in [("1", "fisheye"), ("2", "fisheye-210"), ("3", "fisheye")] {
            let extra = ["--mode", mode, "--seed", seed];
            let run = Run { frames: 4, cupola_frames: 4, extra: &extra, ..Run::new("scattered") };
            let Some(counts) = same(run, rig) else { return };
            let views = off_screen(&counts);
            let (issued, culled) = views.iter().fold((0, 0), |sums, view| (sums.0 + view[0], sums.1 + view[1]));
            assert!(counts["duplicated_draws"].as_u64() >= Some(360), "{mode} {seed}: {counts:#}");
            assert!(issued > 0 && culled > 2 * issued, "{mode} {seed}: {issued} issued, {culled} left out: {counts:#}");
        }
    }
    for (seed, least) in [("1", 589), ("5", 693)] {
        let extra = ["--fbo", "--seed", seed, "--answers", "answers.txt"];
        let run = Run { frames: 6, cupola_frames: 6, extra: &extra, ..Run::new("random_arrays") };
        let Some(counts) = same(run, "fisheye") else { return };
        expect_culled(&counts, least, &format!("random_arrays {seed}"));
    }
}

/// A program that reads its image gets the whole picture, whatever the views show.
fn what_is_read_of_an_image_is_whole() {
    let extra = ["--mode", "chain", "--answers", "own.ppm"];
    let run = Run { frames: 4, cupola_frames: 4, extra: &extra, ..Run::new("scattered") };
    let without = Run { cupola: &["--no-cull"], ..run.clone() };
    let (Some(plain), Some(with), Some(without)) = (run.plain(), run.under("fisheye"), without.under("fisheye")) else {
        return;
    };
    let counts = with.statistics();
    assert!(off_screen(&counts).iter().any(|[_, culled]| *culled > 0), "{counts:#}");
    let own = [plain, with, without].map(|finished| finished.expect_success().picture("own.ppm"));
    expect_identical(&own[1], &own[2], "scattered, what it reads, culled");
    // The view that the program reads has the program's own lens and size, so that nothing is
    // resampled.
    expect_identical(&own[1], &own[0], "scattered, what it reads, without Cupola");
    // Negative control: the picture of a camera that is turned by a degree.
    let Some(turned) = (Run { yaw: run.yaw + 1.0, ..run }).plain() else { return };
    let (different, _) = turned.expect_success().picture("own.ppm").difference(&own[0]);
    assert!(different > 1_000, "only {different} pixels differ for a turned camera");
}

/// The log says if a program leaves out draws beside its own picture, and how to prevent that. It
/// says nothing about other programs.
fn what_a_program_leaves_out_is_told() {
    for (mode, told) in [("culled", true), ("all", false), ("ahead", false)] {
        let extra = ["--mode", mode];
        let run = Run { frames: 30, cupola_frames: 30, extra: &extra, ..Run::new("beside") };
        let Some(finished) = run.under("fisheye") else { return };
        let finished = finished.expect_success().expect_no_gl_errors();
        let says =
            finished.words().contains("seems to leave out what lies beside its own field of view (75.00° × 75.00°)");
        assert_eq!(says, told, "{mode}: {}\n{:#}", finished.words(), finished.statistics());
    }
}

/// A program that reads the projection matrix and computes clipping planes from it draws everything
/// around the viewer if `answer_wide` is set. A profile sets it here. The library chooses the
/// profile because of a library that the program loads.
fn planes_that_a_program_asks_for_are_wide() {
    let folder = scratch("profiles");
    let profiles = folder.join("cupola/profiles");
    std::fs::create_dir_all(&profiles).expect("a folder");
    let profile = "libraries = [\"libX11.so\"]\n[camera]\nanswer_wide = true\n";
    std::fs::write(profiles.join("wide.toml"), profile).expect("a file");
    let environment = [("XDG_CONFIG_HOME", folder.to_str().expect("a UTF-8 path"))];
    let rig = "fisheye";
    let run = |mode: &'static [&str], cupola: &'static [&str]| {
        let run = Run { environment: &environment, extra: mode, cupola, ..Run::new("beside") };
        Some(run.under(rig)?.expect_success().expect_no_gl_errors())
    };
    let (Some(all), Some(asked), Some(without)) = (
        run(&["--mode", "all"], &[]),
        run(&["--mode", "asked"], &[]),
        run(&["--mode", "asked"], &["--profile", "none"]),
    ) else {
        return;
    };
    assert!(asked.words().contains("profile wide (") && asked.words().contains(", for libX11.so"), "{}", asked.words());
    expect_identical(&asked.picture("capture.png"), &all.picture("capture.png"), &format!("beside, asked, {rig}"));
    // Negative control: with its own planes the program leaves out what lies at the sides.
    assert!(!without.words().contains("profile"), "{}", without.words());
    let (different, _) = without.picture("capture.png").difference(&all.picture("capture.png"));
    assert!(different > 1_000, "{rig}: only {different} pixels differ, so the program leaves out nothing");
}
