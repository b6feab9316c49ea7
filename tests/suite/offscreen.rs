//! Programs that draw their scene off screen: each view gets a picture of its own.

use crate::compare::{EDGE, Limits, TOLERANCE, compare, compare_with, expect_good, expect_identical};
use crate::dialects::{camera_of, fisheye, identity, plain, planetarium, shown_by_fisheye, shown_by_window};
use crate::harness::tests;
use crate::programs::{Finished, Run, scratch};
use crate::reference::{Fisheye, Vector, cube_colour, cube_face};

tests! {
    a_program_with_its_own_fbo,
    a_multisampled_window_of_a_program_with_its_own_fbo,
    an_own_fbo_that_is_read_back,
    a_program_with_post_processing,
    passes_that_hold_the_camera_s_matrices,
    a_toolkit_s_two_contexts,
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
    a_background_has_no_seams,
    a_picture_in_a_corner_is_on_the_panel,
    a_flat_scene_is_found_wrong,
}

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

/// Passes that blur mix the colours of both sides of the cube's edges.
const BLURRED_EDGE: f64 = 6.0;

/// Where a pixel of the window is the mean of four texels: that and the two filters after it reach
/// so far, and it rounds to codes twice, so that without Cupola, too, it is off by 0.97 of a code,
/// other programs by 0.50.
const SUPERSAMPLED: Limits = Limits { tolerance: TOLERANCE + 0.5, edge: 3.0, rim: false };

/// A mode of `passes` under the default rig; how right it is, and how far from the cube's edges.
fn passes(mode: &str, limits: impl Into<Limits>, cupola: &[&str]) -> Option<Finished> {
    let run = Run { extra: &["--mode", mode], frames: 6, cupola_frames: 6, cupola, ..Run::new("passes") };
    let finished = run.under("fisheye")?.expect_success().expect_no_gl_errors();
    let picture = finished.picture("capture.png");
    let report = compare_with(&picture, limits, shown_by_fisheye(CIRCLE, camera_of(&run)), cube_colour, cube_face);
    expect_good(&report, &picture, &format!("passes {mode}"));
    Some(finished)
}

/// As [`passes`] for modes that blur nothing.
fn sharp(mode: &str) {
    passes(mode, EDGE, &[]);
}

/// What a program draws into an FBO of its own and then shows, by a copy or by a textured quad, is
/// a scene for every view. GLES 2 shows it by a quad without filtering.
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

/// A multisampled window shows it as well.
fn a_multisampled_window_of_a_program_with_its_own_fbo() {
    fisheye("immediate", &["--fbo", "--samples", "4"]);
    fisheye("post_process", &["--samples", "4"]);
}

/// What a program reads back is its own picture, also while the dome shows each view's.
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

/// A chain of passes: the scene, a change of its colours, and the window; a shadow map besides
/// stays single.
fn a_program_with_post_processing() {
    plain("post_process");
    fisheye("post_process", &[]);
    planetarium("post_process");
    identity("post_process");
    let Some(finished) = Run::new("post_process").under("fisheye") else { return };
    let statistics = finished.expect_success().statistics();
    // Of three frames the first is seen only; the scene and the first pass are duplicated, the
    // shadow map is not.
    assert_eq!(statistics["duplicated_draws"].as_u64(), Some(4), "{statistics:#}");
    assert_eq!(statistics["duplicated_framebuffers"].as_u64(), Some(2), "{statistics:#}");
    let single = statistics["single_framebuffers"].as_object().map_or(0, serde_json::Map::len);
    assert_eq!(single, 1, "{statistics:#}");
}

/// Matrices that do not flow into a pass's positions make no scene of it.
fn passes_that_hold_the_camera_s_matrices() {
    let mode = ["--mode", "matrices"];
    fisheye("post_process", &mode);
    let run = Run { extra: &mode, ..Run::new("post_process") };
    let Some(finished) = run.under("fisheye") else { return };
    let statistics = finished.expect_success().statistics();
    assert_eq!(statistics["duplicated_framebuffers"].as_u64(), Some(2), "{statistics:#}");
}

/// A context without a window draws the scene, another one composes the window of it.
fn a_toolkit_s_two_contexts() {
    plain("toolkit");
    fisheye("toolkit", &[]);
    planetarium("toolkit");
    identity("toolkit");
    let Some(finished) = Run::new("toolkit").under("fisheye") else { return };
    let finished = finished.expect_success().expect_no_gl_errors();
    let statistics = finished.statistics();
    // Of three frames the first is seen only.
    assert_eq!(statistics["duplicated_draws"].as_u64(), Some(2), "{statistics:#}");
    // Both contexts are counted.
    assert_eq!(statistics["duplicated_framebuffers"].as_u64(), Some(1), "{statistics:#}");
    assert!(statistics["projection_found"]["fixed-function matrix"].as_u64() >= Some(2), "{statistics:#}");
    assert!(!finished.words().contains("shown flat"), "{}", finished.words());
}

/// A scene that fills only a part of the window: the program is told why it is flat, and the
/// statistics say it.
fn a_scene_that_stays_flat_is_told() {
    let run = Run { extra: &["--mode", "docked"], frames: 310, cupola_frames: 310, ..Run::new("toolkit") };
    let Some(finished) = run.under("fisheye") else { return };
    let finished = finished.expect_success();
    assert!(finished.words().contains("the program's scene is shown flat"), "{}", finished.words());
    let statistics = finished.statistics();
    assert!(statistics["single_framebuffers"]["it was not seen to fill the window"].is_u64(), "{statistics:#}");
}

/// The user's word goes before what is seen: that of the rig, before it that of the environment,
/// before both that of the command line.
fn duplication_can_be_switched_off_and_forced() {
    let rig = scratch("never").join("rig.toml");
    let text = "[views]\nduplicate = \"never\"\n[[output]]\nkind = \"domemaster\"\naperture = 180\n";
    std::fs::write(&rig, text).expect("a file can be written");
    let rig = rig.to_str().expect("a UTF-8 path");
    let (never, always) = (["--duplicate", "never"], [("CUPOLA_DUPLICATE", "always")]);
    // The shadow map, too: three passes in each of two frames.
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

/// A pass over the scene that finds what it lights by its place on the screen.
fn a_pass_that_asks_where_on_the_screen_it_is() {
    sharp("light");
}

fn sizes_other_than_the_window_s() {
    passes("bloom", BLURRED_EDGE, &[]);
    passes("twice", SUPERSAMPLED, &[]);
    sharp("power");
    sharp("rectangle");
}

fn smaller_pictures_of_the_scene() {
    passes("mipmap", BLURRED_EDGE, &[]);
}

fn copies_into_textures() {
    sharp("copied");
    sharp("copied_window");
    // What is copied of a window without a scene is flat, as all that follows.
    let run = Run { extra: &["--mode", "copied_flat"], ..Run::new("passes") };
    let Some(finished) = run.under("fisheye") else { return };
    let statistics = finished.expect_success().expect_no_gl_errors().statistics();
    assert_eq!(statistics["duplicated_draws"].as_u64(), Some(0), "{statistics:#}");
}

/// A texture that is specified anew is learnt anew, which takes a frame; the last of six is beyond
/// it.
fn attachments_and_textures_that_change() {
    sharp("attached_again");
    sharp("respecified");
}

fn old_and_new_entry_points() {
    fisheye("ext_framebuffer", &[]);
    sharp("blit");
    sharp("plain");
}

/// The comparison sees a scene that is flat, whichever way it is shown.
fn a_flat_scene_is_found_wrong() {
    for mode in ["plain", "blit", "copied"] {
        let run = Run { extra: &["--mode", mode], cupola: &["--duplicate", "never"], ..Run::new("passes") };
        let Some(finished) = run.under("fisheye") else { return };
        let picture = finished.expect_success().picture("capture.png");
        let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
        assert!(report.wrong * 2 > report.compared, "{mode}: only {} of {}", report.wrong, report.compared);
    }
}

/// A head-up display that is drawn into the scene's image lies where one in the window lies: once,
/// on the panel's place.
fn flat_drawing_into_a_scene() {
    let run = Run { frames: 6, cupola_frames: 6, ..Run::new("hud") };
    let off_screen = Run { extra: &["--fbo"], ..run.clone() };
    let (Some(expected), Some(found)) = (run.under("fisheye"), off_screen.under("fisheye")) else { return };
    let [expected, found] =
        [expected, found].map(|run| run.expect_success().expect_no_gl_errors().picture("capture.png"));
    // Only borders of the squares differ: they are blended once in the views, and once with the
    // panel.
    let far = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > 12);
    let pixels = || (0..256).flat_map(|y| (0..256).map(move |x| (x, y)));
    let wrong = pixels().filter(|(x, y)| far(found.at(*x, *y), expected.at(*x, *y))).count();
    assert!(wrong < 120, "{wrong} pixels differ");
    // Control: the squares have 200 pixels and more.
    let Some(plain) = (Run { program: "immediate", ..run }).under("fisheye") else { return };
    let plain = plain.expect_success().picture("capture.png");
    let squares = pixels().filter(|(x, y)| far(plain.at(*x, *y), expected.at(*x, *y))).count();
    assert!(squares > 200, "{squares} pixels are of the squares");
}

/// Colours that change with the place in the program's window, as background of a scene's image:
/// within the lens those of the window, beyond its sides those of equal elevation, and outside
/// those of the border.
fn a_background_has_no_seams() {
    let tangent = (0.5 * 75.0_f64.to_radians()).tan();
    let expected = |[x, y, z]: Vector| {
        let nearest = (-z).max(x.hypot(z) / tangent.hypot(1.0)).max(1e-4);
        let at = [x / tangent / (-z).max(1e-4), y / tangent / nearest];
        let [right, up] = at.map(|at| 255.0 * (0.5 + 0.5 * at.clamp(-1.0, 1.0)));
        [right, up, 0.25 * 255.0]
    };
    for mode in ["plain", "multisampled"] {
        let extra = ["--mode", mode, "--shot", "shot.ppm"];
        let run = Run { extra: &extra, frames: 6, cupola_frames: 6, ..Run::new("backdrop") };
        let Some(under) = run.under("fisheye") else { return };
        let picture = under.expect_success().expect_no_gl_errors().picture("capture.png");
        let off = |x: usize, y: usize| {
            let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
            // The scene, and where the picture's whole width meets above and below.
            let direction = CIRCLE.direction(x, y);
            if CIRCLE.inside_by(x, y) < 2.0 || direction[2] < -0.95 || direction[1].abs() > 0.98 {
                return 0.0;
            }
            let found = picture.at(x as usize, y as usize).map(f64::from);
            found.iter().zip(expected(direction)).fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()))
        };
        let pixels = || (0..256).flat_map(|y| (0..256).map(move |x| (x, y)));
        let wrong = pixels().filter(|(x, y)| off(*x, *y) > 4.0).count();
        assert!(
            wrong == 0,
            "{mode}: {wrong} pixels are off, the worst by {}",
            pixels().fold(0.0, |w: f64, (x, y)| w.max(off(x, y)))
        );
        let middle = picture.at(128, 128);
        assert!(
            expected([0.0, 0.0, -1.0]).iter().zip(middle).any(|(a, b)| (a - f64::from(b)).abs() > 30.0),
            "the scene"
        );
        let Some(own) = run.under("identity-captured") else { return };
        let own = own.expect_success().expect_no_gl_errors().picture("shot.ppm");
        let Some(plain) = run.plain() else { return };
        expect_identical(&own, &plain.expect_success().picture("shot.ppm"), mode);
    }
}

/// A scene in a corner of the image is where that corner of the panel is. It is cut at rectangles
/// of the views, which are turned by 45 degrees, so that some of it lies beside.
fn a_picture_in_a_corner_is_on_the_panel() {
    let (plain, corner) = (["--mode", "plain"], ["--mode", "corner"]);
    let run = Run { frames: 6, cupola_frames: 6, ..Run::new("backdrop") };
    let pictures = [&plain, &corner].map(|extra| Run { extra, ..run.clone() }.under("fisheye"));
    let [Some(plain), Some(corner)] = pictures else { return };
    let [plain, corner] = [plain, corner].map(|run| run.expect_success().expect_no_gl_errors().picture("capture.png"));
    let (lens, panel) = ((0.5 * 75.0_f64.to_radians()).tan(), 30.0_f64.to_radians().tan());
    let mut seen = 0;
    for (x, y) in (0..256).flat_map(|y| (0..256).map(move |x| (x, y))) {
        let [right, up, back] = CIRCLE.direction(x as f64 + 0.5, y as f64 + 0.5);
        // The place in the lower left quarter of the panel, which is as wide as the picture.
        let at = [right, up].map(|part| 2.0 * part / -back.min(-1e-3) / panel + 1.0);
        let inside = at.iter().fold(0.0, |most: f64, at| most.max(at.abs()));
        let found = corner.at(x, y).map(f64::from);
        if inside < 0.9 {
            let expected = cube_colour([at[0] * lens, at[1] * lens, -1.0]).map(|c| 255.0 * c);
            let off = found.iter().zip(expected).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
            assert!(off < 6.0, "({x}, {y}) is {found:?} instead of {expected:?}");
            seen += 1;
        } else if inside > 2.4 {
            assert_eq!(corner.at(x, y), plain.at(x, y), "({x}, {y})");
        }
    }
    assert!(seen > 500, "{seen} pixels");
}
