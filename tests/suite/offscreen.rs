//! Programs that draw their scene off screen: each view gets a copy of the picture.

use crate::compare::{BORDERS, Limits, Shown, beyond_neighbours, compare, compare_with, expect_alike, expect_good};
use crate::dialects::{camera_of, fisheye, identity, plain, planetarium, shown_by_fisheye, shown_by_window};
use crate::harness::tests;
use crate::picture::Picture;
use crate::programs::{Finished, Run, scratch};
use crate::reference::{Fisheye, cube_colour, cube_face};

tests! {
    a_program_with_its_own_fbo,
    a_multisampled_window_of_a_program_with_its_own_fbo,
    an_own_fbo_that_is_read_back,
    a_program_with_post_processing,
    passes_that_hold_the_camera_s_matrices,
    a_toolkit_s_two_contexts,
    a_toolkit_s_window_that_is_not_shown,
    a_window_that_is_shown_later,
    a_scene_between_widgets,
    a_scene_that_stays_flat_is_told,
    duplication_can_be_switched_off_and_forced,
    samples_that_are_resolved,
    depth_and_several_attachments,
    a_pass_that_asks_where_on_the_screen_it_is,
    sizes_other_than_the_window_s,
    smaller_pictures_of_the_scene,
    copies_into_textures,
    attachments_and_textures_that_change,
    old_and_new_entry_points,
    flat_drawing_into_a_scene,
    a_panel_of_the_first_frames_leaves_nothing_behind,
    a_flat_scene_is_found_wrong,
}

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

/// Checks a mode of `passes` under the default rig within `limits`.
fn passes(mode: &str, limits: Limits) {
    let run = Run { extra: &["--mode", mode], frames: 6, cupola_frames: 6, ..Run::new("passes") };
    let Some(finished) = run.under("fisheye") else { return };
    let finished = finished.expect_success().expect_no_gl_errors();
    let picture = finished.picture("capture.png");
    let report = compare_with(&picture, limits, shown_by_fisheye(CIRCLE, camera_of(&run)), cube_colour, cube_face);
    expect_good(&report, &picture, &format!("passes {mode}"));
}

/// As [`passes`], within the usual limits.
fn sharp(mode: &str) {
    passes(mode, Limits::USUAL);
}

/// If a program draws its scene into an FBO of its own and shows it by a copy or by a textured
/// quad, the scene is drawn for every view. GLES 2 shows it by a quad without filtering.
fn a_program_with_its_own_fbo() {
    for program in ["immediate", "client_arrays", "glsl120", "core330_mvp", "core330_block", "gles2", "gles3"] {
        fisheye(program, &["--fbo"]);
    }
    let run = Run { extra: &["--fbo"], ..Run::new("gles2") };
    let Some(finished) = run.under("fisheye") else { return };
    let statistics = finished.expect_success().statistics();
    assert_eq!(statistics["duplicated_draws"].as_u64(), Some(2), "{statistics:#}");
    assert_eq!(statistics["duplicated_framebuffers"].as_u64(), Some(1), "{statistics:#}");
}

/// The same with a multisampled window.
fn a_multisampled_window_of_a_program_with_its_own_fbo() {
    fisheye("immediate", &["--fbo", "--samples", "4"]);
    fisheye("post_process", &["--samples", "4"]);
}

/// A program that reads its FBO gets its own picture, although the dome shows the views.
fn an_own_fbo_that_is_read_back() {
    let run = Run { extra: &["--fbo", "--dump", "dump.ppm"], ..Run::new("core330_mvp") };
    let Some(finished) = run.under("fisheye") else { return };
    let finished = finished.expect_success().expect_no_gl_errors();
    for (file, what) in [("dump.ppm", "read back"), ("capture.png", "shown")] {
        let picture = finished.picture(file);
        let report = if file == "dump.ppm" {
            compare(&picture, shown_by_window(run.size, run.fov, camera_of(&run)))
        } else {
            compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)))
        };
        expect_good(&report, &picture, &format!("core330_mvp, its own FBO {what}"));
    }
    sharp("read");
}

/// A chain of passes: the scene, a change of its colours, and the window. A shadow map is also
/// drawn, once for all views.
fn a_program_with_post_processing() {
    plain("post_process");
    fisheye("post_process", &[]);
    planetarium("post_process");
    identity("post_process");
    let Some(finished) = Run::new("post_process").under("fisheye") else { return };
    let statistics = finished.expect_success().statistics();
    // The first of three frames is only observed. The scene and the first pass are duplicated, the
    // shadow map is not.
    assert_eq!(statistics["duplicated_draws"].as_u64(), Some(4), "{statistics:#}");
    assert_eq!(statistics["duplicated_framebuffers"].as_u64(), Some(2), "{statistics:#}");
    let single = statistics["single_framebuffers"].as_object().map_or(0, serde_json::Map::len);
    assert_eq!(single, 1, "{statistics:#}");
}

/// A pass with matrices is no scene if its positions do not depend on them.
fn passes_that_hold_the_camera_s_matrices() {
    let mode = ["--mode", "matrices"];
    fisheye("post_process", &mode);
    let run = Run { extra: &mode, ..Run::new("post_process") };
    let Some(finished) = run.under("fisheye") else { return };
    let statistics = finished.expect_success().statistics();
    assert_eq!(statistics["duplicated_framebuffers"].as_u64(), Some(2), "{statistics:#}");
}

/// A context without a window draws the scene. Another context draws the window with it.
fn a_toolkit_s_two_contexts() {
    plain("toolkit");
    fisheye("toolkit", &[]);
    planetarium("toolkit");
    identity("toolkit");
    let Some(finished) = Run::new("toolkit").under("fisheye") else { return };
    let finished = finished.expect_success().expect_no_gl_errors();
    let statistics = finished.statistics();
    // The first of three frames is only observed.
    assert_eq!(statistics["duplicated_draws"].as_u64(), Some(2), "{statistics:#}");
    // The numbers are those of both contexts.
    assert_eq!(statistics["duplicated_framebuffers"].as_u64(), Some(1), "{statistics:#}");
    assert!(statistics["projection_found"]["fixed-function matrix"].as_u64() >= Some(2), "{statistics:#}");
    assert!(!finished.words().contains("shown flat"), "{}", finished.words());
}

/// The context that draws the scene has a window, too, which is not shown. The views are those of the
/// window that is shown, also after they were planned anew for the few draws.
fn a_toolkit_s_window_that_is_not_shown() {
    let run = Run { extra: &["--mode", "unmapped"], frames: 14, cupola_frames: 14, ..Run::new("toolkit") };
    let Some(finished) = run.under("fisheye") else { return };
    let finished = finished.expect_success().expect_no_gl_errors();
    let picture = finished.picture("capture.png");
    expect_good(&compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run))), &picture, "an unmapped window");
    assert_eq!(finished.statistics()["views"].as_array().map(Vec::len), Some(5), "they were not planned anew");
}

/// A window that is mapped after its context became current is corrected from its first swap on.
fn a_window_that_is_shown_later() {
    let run =
        Run { extra: &["--mode", "late", "--shot", "shot.ppm"], frames: 10, cupola_frames: 0, ..Run::new("toolkit") };
    let Some(finished) = run.under("fisheye") else { return };
    let picture = finished.expect_success().expect_no_gl_errors().picture("shot.ppm");
    expect_good(
        &compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run))),
        &picture,
        "a window that is shown later",
    );
}

/// A toolkit shows a scene in most of the window, with widgets below and above it. The scene is all
/// around, and the panel has the widgets and a hole.
fn a_scene_between_widgets() {
    for (mode, samples) in [("panes", "0"), ("panes-copied", "0"), ("panes", "4")] {
        let extra = ["--mode", mode, "--samples", samples];
        let run = Run { extra: &extra, frames: 8, cupola_frames: 8, ..Run::new("toolkit") };
        let Some(finished) = run.under("fisheye") else { return };
        let finished = finished.expect_success().expect_no_gl_errors();
        let what = format!("toolkit {mode}, {samples} samples");
        let corner = ([200.0, 46.0, 232.0, 78.0], [0, 0, 255]);
        expect_between_widgets(&finished.picture("capture.png"), Limits::USUAL, &run, &[corner], &what);
    }
}

/// A rectangle of the window (left, bottom, right, top) and its colour.
type Widget = ([f64; 4], [u8; 3]);

/// Checks a domemaster of a scene in most of the window, between an orange background and a green
/// menu. The scene is within `limits`. `corners`: flat drawing over it, besides the white square.
pub fn expect_between_widgets(picture: &Picture, limits: Limits, run: &Run<'_>, corners: &[Widget], what: &str) {
    let edge = 30.0_f64.to_radians().tan();
    // Place on the panel in pixels of the window. `None`: beside the panel.
    let on_panel = |x: f64, y: f64| {
        let [right, up, back] = CIRCLE.direction(x, y);
        let at = [right, up].map(|part| 128.0 + 128.0 * part / -back.min(-1e-3) / edge);
        (back < 0.0 && at.iter().all(|at| (-6.0..262.0).contains(at))).then_some(at)
    };
    let within = |[x, y]: [f64; 2], [left, bottom, right, top]: [f64; 4]| {
        (left..right).contains(&x) && (bottom..top).contains(&y)
    };
    let scene = shown_by_fisheye(CIRCLE, camera_of(run));
    // The white square lies at the same place of the window on the panel.
    let square: Widget = ([62.0, 59.0, 80.0, 72.0], [255, 255, 255]);
    let near = |[left, bottom, right, top]: [f64; 4]| [left - 12.0, bottom - 12.0, right + 12.0, top + 12.0];
    let flat: Vec<Widget> = corners.iter().copied().chain([square]).collect();
    let is_near_flat = |at: [f64; 2]| flat.iter().any(|(place, _)| within(at, near(*place)));
    let shown = |x: f64, y: f64| match on_panel(x, y) {
        Some(at) if !within(at, [38.0, 38.0, 250.0, 218.0]) || is_near_flat(at) => Shown::Unknown,
        _ => scene(x, y),
    };
    expect_good(&compare_with(picture, limits, shown, cube_colour, cube_face), picture, what);
    let widgets: [Widget; 3] = [
        ([6.0, 6.0, 250.0, 26.0], [255, 128, 0]),
        ([6.0, 6.0, 26.0, 218.0], [255, 128, 0]),
        ([6.0, 230.0, 250.0, 250.0], [0, 128, 0]),
    ];
    let widgets: Vec<Widget> = flat.into_iter().chain(widgets).collect();
    let mut seen = vec![0; widgets.len()];
    for (x, y) in (0..256).flat_map(|y| (0..256).map(move |x| (x, y))) {
        let Some(at) = on_panel(x as f64 + 0.5, y as f64 + 0.5) else { continue };
        for (count, (_, colour)) in seen.iter_mut().zip(&widgets).filter(|(_, (place, _))| within(at, *place)) {
            let found = picture.at(x, y);
            assert!(found.iter().zip(colour).all(|(a, b)| a.abs_diff(*b) <= 2), "{what}: ({x}, {y}) is {found:?}");
            *count += 1;
        }
    }
    assert!(seen.iter().all(|count| *count > 20), "{what}: {seen:?} pixels of the widgets");
}

/// A scene fills only a part of the window. The log and the statistics say why it is flat.
fn a_scene_that_stays_flat_is_told() {
    let run = Run { extra: &["--mode", "docked"], frames: 310, cupola_frames: 310, ..Run::new("toolkit") };
    let Some(finished) = run.under("fisheye") else { return };
    let finished = finished.expect_success();
    assert!(finished.words().contains("the program's scene is shown flat"), "{}", finished.words());
    let statistics = finished.statistics();
    let reason = "it is shown in less than half of the window: make it larger, or close what is beside it";
    assert!(statistics["single_framebuffers"][reason].is_u64(), "{statistics:#}");
    assert!(finished.words().contains(reason), "{}", finished.words());
}

/// Settings have priority over what Cupola observes: first the command line, then the environment,
/// then the rig.
fn duplication_can_be_switched_off_and_forced() {
    let rig = scratch("never").join("rig.toml");
    let text = "[views]\nduplicate = \"never\"\n[[output]]\nkind = \"domemaster\"\naperture = 180\n";
    std::fs::write(&rig, text).expect("a file can be written");
    let rig = rig.to_str().expect("a UTF-8 path");
    let (never, always) = (["--duplicate", "never"], [("CUPOLA_DUPLICATE", "always")]);
    // With `always` the shadow map is duplicated, too: three passes in each of two frames.
    for (rig, option, environment, expected) in [
        ("fisheye", &never[..], &[][..], 0),
        ("fisheye", &[], &always, 6),
        (rig, &[], &[], 0),
        (rig, &[], &always, 6),
        (rig, &never, &always, 0),
    ] {
        let run = Run { cupola: option, environment, ..Run::new("post_process") };
        let Some(finished) = run.under(rig) else { return };
        let statistics = finished.expect_success().expect_no_gl_errors().statistics();
        assert_eq!(statistics["duplicated_draws"].as_u64(), Some(expected), "{rig} {option:?} {environment:?}");
    }
}

fn samples_that_are_resolved() {
    sharp("resolve");
    sharp("resolve_to_window");
    sharp("samples");
}

fn depth_and_several_attachments() {
    sharp("depth");
    sharp("apart");
}

/// A pass over the scene that computes lighting from its place on the screen.
fn a_pass_that_asks_where_on_the_screen_it_is() {
    sharp("light");
}

fn sizes_other_than_the_window_s() {
    sharp("bloom");
    // A pixel of the window is the mean of four texels, so values are rounded twice.
    passes("twice", Limits::ROUNDED);
    sharp("power");
    sharp("rectangle");
}

fn smaller_pictures_of_the_scene() {
    sharp("mipmap");
}

fn copies_into_textures() {
    sharp("copied");
    sharp("copied_window");
    // A copy of a window without a scene is flat, and so is everything that is drawn from it.
    let run = Run { extra: &["--mode", "copied_flat"], ..Run::new("passes") };
    let Some(finished) = run.under("fisheye") else { return };
    let statistics = finished.expect_success().expect_no_gl_errors().statistics();
    assert_eq!(statistics["duplicated_draws"].as_u64(), Some(0), "{statistics:#}");
}

/// Cupola observes a texture again after it is specified again, which takes a frame. The last of
/// six frames is after that.
fn attachments_and_textures_that_change() {
    sharp("attached_again");
    sharp("respecified");
}

fn old_and_new_entry_points() {
    fisheye("ext_framebuffer", &[]);
    sharp("blit");
    sharp("plain");
}

/// Negative control: the comparison detects a flat scene in each way of showing it.
fn a_flat_scene_is_found_wrong() {
    for mode in ["plain", "blit", "copied"] {
        let run = Run { extra: &["--mode", mode], cupola: &["--duplicate", "never"], ..Run::new("passes") };
        let Some(finished) = run.under("fisheye") else { return };
        let picture = finished.expect_success().picture("capture.png");
        let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
        assert!(report.wrong * 2 > report.compared, "{mode}: only {} of {}", report.wrong, report.compared);
    }
}

/// A panel that is not used any more is removed, and the pictures are those of a program that never
/// needed one. It comes back when it is used again.
fn a_panel_of_the_first_frames_leaves_nothing_behind() {
    let picture = |mode: &[&str]| {
        let run = Run { frames: 80, cupola_frames: 80, size: (128, 128), extra: mode, ..Run::new("hud") };
        Some(run.under("fisheye")?.expect_success().expect_no_gl_errors())
    };
    let (Some(never), Some(first)) = (picture(&["--mode", "never"]), picture(&["--mode", "first"])) else { return };
    let (Some(always), Some(again)) = (picture(&["--mode", "always"]), picture(&["--mode", "again"])) else { return };
    let different =
        |one: &Finished, other: &Finished| one.picture("capture.png").difference(&other.picture("capture.png")).0;
    assert_eq!(different(&first, &never), 0, "something is left");
    assert_eq!(different(&again, &always), 0, "the panel does not come back");
    // Control: the squares are seen.
    assert!(different(&always, &never) > 50, "{}", different(&always, &never));
}

/// A head-up display that is drawn into the scene's image is at the same place as one in the
/// window: once, on the panel.
fn flat_drawing_into_a_scene() {
    let run = Run { frames: 6, cupola_frames: 6, ..Run::new("hud") };
    let off_screen = Run { extra: &["--fbo"], ..run.clone() };
    let (Some(expected), Some(found)) = (run.under("fisheye"), off_screen.under("fisheye")) else { return };
    let [expected, found] =
        [expected, found].map(|run| run.expect_success().expect_no_gl_errors().picture("capture.png"));
    // Only the borders of the squares differ. They are blended once in the views and once with the
    // panel.
    expect_alike(&found, &expected, BORDERS, "hud in its own image");
    let far = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > 12);
    let pixels = || (0..256).flat_map(|y| (0..256).map(move |x| (x, y)));
    let wrong = pixels().filter(|(x, y)| far(found.at(*x, *y), expected.at(*x, *y))).count();
    // 84 pixels were found.
    assert!(wrong < 100, "{wrong} pixels differ");
    // Control: the squares cover more than 200 pixels and are not like the cube.
    let Some(plain) = (Run { program: "immediate", ..run }).under("fisheye") else { return };
    let plain = plain.expect_success().picture("capture.png");
    let squares = pixels().filter(|(x, y)| far(plain.at(*x, *y), expected.at(*x, *y))).count();
    assert!(squares > 200, "{squares} pixels are of the squares");
    assert!(beyond_neighbours(&expected, &plain, 1).0 > 40, "the squares have the colours of the cube");
}
