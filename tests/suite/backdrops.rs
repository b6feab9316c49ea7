//! Backgrounds that fill the program's picture before the scene, and pictures in a corner.

use crate::compare::expect_identical;
use crate::harness::tests;
use crate::picture::Picture;
use crate::programs::Run;
use crate::reference::{Fisheye, Vector, cube_colour};

tests! {
    a_background_has_no_seams,
    a_background_of_opengl_es,
    a_background_of_vulkan,
    a_picture_in_a_corner_is_on_the_panel,
}

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

/// The background in a direction. Its colours depend on the place in the program's window: to the
/// right, up, and a constant. Inside the program's field of view they are those of the window. To the
/// sides they are those at the same elevation, and elsewhere those at the border.
fn background([x, y, z]: Vector) -> Vector {
    let tangent = (0.5 * 75.0_f64.to_radians()).tan();
    let nearest = (-z).max(x.hypot(z) / tangent.hypot(1.0)).max(1e-4);
    let at = [x / tangent / (-z).max(1e-4), y / tangent / nearest];
    let [right, up] = at.map(|at| 255.0 * (0.5 + 0.5 * at.clamp(-1.0, 1.0)));
    [right, up, 0.25 * 255.0]
}

/// Checks a picture whose colour in a direction should be `expected`. `skip`: directions with other
/// things.
fn expect_background(
    picture: &Picture,
    expected: impl Fn(Vector) -> Vector,
    skip: impl Fn(Vector, Vector) -> Option<bool>,
    what: &str,
) {
    let off = |x: usize, y: usize| {
        let direction = CIRCLE.direction(x as f64 + 0.5, y as f64 + 0.5);
        // Not compared: the scene, and the areas above and below where the whole width of the
        // picture meets.
        let inside = CIRCLE.inside_by(x as f64 + 0.5, y as f64 + 0.5);
        if inside < 2.0 || direction[2] < -0.95 || direction[1].abs() > 0.98 {
            return 0.0;
        }
        let found = picture.at(x, y).map(f64::from);
        if let Some(right) = skip(direction, found) {
            return if right { 0.0 } else { 255.0 };
        }
        found.iter().zip(expected(direction)).fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()))
    };
    let pixels = || (0..256).flat_map(|y| (0..256).map(move |x| (x, y)));
    let wrong = pixels().filter(|(x, y)| off(*x, *y) > 4.0).count();
    let worst = pixels().fold(0.0, |worst: f64, (x, y)| worst.max(off(x, y)));
    println!("{what}: the worst pixel is off by {worst:.2}");
    assert!(wrong == 0, "{what}: {wrong} pixels are off, the worst by {worst}");
    let (middle, behind) = (picture.at(128, 128), expected([0.0, 0.0, -1.0]));
    assert!(behind.iter().zip(middle).any(|(a, b)| (a - f64::from(b)).abs() > 30.0), "{what}: the scene");
}

/// A background that is drawn to the image of a scene or to the window itself.
fn a_background_has_no_seams() {
    // A place on the panel: −1…1 to the right and up.
    let on_panel = |[x, y, z]: Vector| [x, y].map(|part| part / (-z).max(1e-3) / 30.0_f64.to_radians().tan());
    let in_window = [("window", "0"), ("window", "4"), ("blended", "0"), ("between", "0")];
    for (mode, samples) in [("plain", "0"), ("multisampled", "0")].into_iter().chain(in_window) {
        // Half of the clear's colour.
        let expected = |direction| match mode {
            "blended" => background(direction).map(|colour| 0.5 * colour + 0.5 * 64.0),
            _ => background(direction),
        };
        let extra = ["--mode", mode, "--samples", samples, "--shot", "shot.ppm"];
        let run = Run { extra: &extra, frames: 6, cupola_frames: 6, ..Run::new("backdrop") };
        let Some(under) = run.under("fisheye") else { return };
        let picture = under.expect_success().expect_no_gl_errors().picture("capture.png");
        // The widget is at the left border of the panel.
        let widget = |direction, found: Vector| {
            let [right, up] = on_panel(direction);
            let inside = (-0.98..-0.82).contains(&right) && up.abs() < 0.97;
            let near = mode == "between" && (-1.03..-0.77).contains(&right) && up.abs() < 1.03;
            near.then(|| !inside || (found[2] - 64.0).abs() >= 60.0)
        };
        expect_background(&picture, expected, widget, &format!("{mode}, {samples} samples"));
        // Mesa resolves samples of a window and of a framebuffer object with other roundings.
        if samples != "0" {
            continue;
        }
        let Some(own) = run.under("identity-captured") else { return };
        let own = own.expect_success().expect_no_gl_errors().picture("shot.ppm");
        let Some(plain) = run.plain() else { return };
        expect_identical(&own, &plain.expect_success().picture("shot.ppm"), mode);
    }
}

/// The same in OpenGL ES, which cannot count samples.
fn a_background_of_opengl_es() {
    for mode in ["plain", "window"] {
        let extra = ["--mode", mode, "--shot", "shot.ppm"];
        let run = Run { extra: &extra, frames: 6, cupola_frames: 6, ..Run::new("gles3_backdrop") };
        let (Some(plain), Some(under)) = (run.plain(), run.under("fisheye")) else { return };
        let picture = under.expect_success().expect_no_gl_errors().picture("capture.png");
        expect_background(&picture, background, |_, _| None, &format!("OpenGL ES, {mode}"));
        let Some(own) = run.under("identity-captured") else { return };
        let own = own.expect_success().expect_no_gl_errors().picture("shot.ppm");
        expect_identical(&own, &plain.expect_success().picture("shot.ppm"), mode);
    }
    // A window with several samples cannot be copied in parts there: the background is on the panel.
    let extra = ["--mode", "window", "--samples", "4"];
    let run = Run { extra: &extra, frames: 6, cupola_frames: 6, ..Run::new("gles3_backdrop") };
    let Some(under) = run.under("fisheye") else { return };
    let picture = under.expect_success().expect_no_gl_errors().picture("capture.png");
    let above = picture.at(128, 16).map(f64::from);
    let expected = background(CIRCLE.direction(128.5, 16.5));
    assert!(above.iter().zip(expected).any(|(a, b)| (a - b).abs() > 30.0), "{above:?}");
}

/// A background of Vulkan: off screen, with colours that come from an input of the fragment shader or
/// from `FragCoord`, and in the window.
fn a_background_of_vulkan() {
    // The shader's second number grows downwards.
    let down = |[x, y, z]: Vector| background([x, -y, z]);
    for way in ["gradient", "placed", "behind"] {
        let extra = ["--way", way, "--shot", "shot.ppm"];
        let run = Run { extra: &extra, frames: 6, yaw: 0.0, pitch: 0.0, ..Run::new("vk_scenes") };
        let Some(under) = run.vulkan_under("fisheye") else { return };
        expect_background(&under.picture("capture.png"), down, |_, _| None, &format!("vk_scenes {way}"));
        let (Some(plain), Some(own)) = (run.vulkan_plain(), run.vulkan_under("identity-captured")) else { return };
        expect_identical(&own.picture("shot.ppm"), &plain.expect_success().picture("shot.ppm"), way);
    }
}

/// A scene in a corner of the image is in the same corner of the panel. It is cut at rectangles in
/// the views. The views are turned by 45 degrees, so that a part of the scene extends beyond the
/// corner.
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
        // Place within the lower left quarter of the panel. The panel shows the whole width of the
        // picture.
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
