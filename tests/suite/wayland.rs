//! Programs with windows of Wayland and without any X server. The compositor has no visible screen.

use crate::compare::expect_identical;
use crate::display::Compositor;
use crate::harness::tests;
use crate::programs::{Finished, installed, installed_in};

tests! {
    vkcube_is_as_in_a_window_of_x11,
    opengl_draws_scenes_and_panels,
}

const FRAMES: &str = "5";

/// The angle of the cube depends only on the frame, so both window systems must show the same.
fn vkcube_is_as_in_a_window_of_x11() {
    let options = ["--frames", FRAMES, "--capture", "capture.png", "--stats", "stats.json"];
    let Some(compositor) = Compositor::start() else { return };
    let size = ["--width", "300", "--height", "300"];
    let Some(found) = installed_in(&compositor, "vkcube-wayland", &size, "fisheye", &options) else { return };
    let x11 = installed("vkcube", &size, "fisheye", &options);
    let Some(expected) = x11.map(Finished::expect_success) else { return };
    let found = found.expect_success();
    assert_eq!(found.statistics()["frames"], 5);
    expect_identical(&found.picture("capture.png"), &expected.picture("capture.png"), "vkcube-wayland");
}

/// A scene of OpenGL ES in a window of 300 × 300 pixels, and flat drawing in a window that fills
/// the screen.
fn opengl_draws_scenes_and_panels() {
    let options = ["--frames", FRAMES, "--capture", "capture.png", "--stats", "stats.json"];
    let Some(compositor) = Compositor::start() else { return };
    let run = |program: &str, arguments: &[&str]| {
        installed_in(&compositor, program, arguments, "fisheye", &options)
            .map(|run| run.expect_success().expect_no_gl_errors())
    };
    if let Some(gears) = run("es2gears_wayland", &[]) {
        let (statistics, picture) = (gears.statistics(), gears.picture("capture.png"));
        assert_eq!((picture.width, picture.height), (300, 300));
        assert!(statistics["draws_seen"].as_u64() > Some(0) && statistics["panel_draws"] == 0, "{statistics:#}");
        let red = picture.pixels.iter().filter(|[r, g, b]| *r > 100 && *g < 60 && *b < 60).count();
        assert!(red > 50, "{red} pixels of the red gear are seen");
    }
    if let Some(triangle) = run("weston-simple-egl", &["-f"]) {
        let (statistics, picture) = (triangle.statistics(), triangle.picture("capture.png"));
        assert_eq!((picture.width, picture.height), Compositor::SIZE);
        assert_eq!(statistics["panel_draws"], statistics["draws_seen"], "{statistics:#}");
    }
}
