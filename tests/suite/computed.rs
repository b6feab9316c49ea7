//! OpenGL programs whose compute shaders make pictures of the scene.

use crate::compare::{Limits, compare_with, expect_good, expect_identical};
use crate::dialects::{CAMERAS, camera_of, planetarium_of, shown_by_fisheye, shown_by_window};
use crate::harness::tests;
use crate::programs::Run;
use crate::reference::{Fisheye, cube_colour, cube_face};

tests! {
    pictures_that_compute_shaders_make,
    an_image_of_half_the_size,
    sums_of_the_whole_picture_are_made_once,
    matrices_of_compute_shaders_are_those_of_the_view,
    values_of_each_place_are_not_followed,
}

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

fn run<'a>(extra: &'a [&'a str]) -> Run<'a> {
    let (fov, yaw, pitch) = CAMERAS[1];
    Run { fov, yaw, pitch, extra, frames: 6, cupola_frames: 6, ..Run::new("computed") }
}

/// Each mode shows the predicted picture without Cupola and on a dome. With the program's own lens
/// it shows the same as without Cupola, to the byte.
fn right(modes: &[&str], limits: Limits) {
    for mode in modes {
        let extra = ["--mode", mode, "--shot", "shot.ppm"];
        let run = run(&extra);
        let Some(plain) = run.plain() else { return };
        let plain = plain.expect_success().picture("shot.ppm");
        let report =
            compare_with(&plain, limits, shown_by_window(run.size, run.fov, camera_of(&run)), cube_colour, cube_face);
        expect_good(&report, &plain, &format!("computed {mode} plain"));
        let Some(under) = run.under("fisheye") else { return };
        let picture = under.expect_success().expect_no_gl_errors().picture("capture.png");
        let report = compare_with(&picture, limits, shown_by_fisheye(CIRCLE, camera_of(&run)), cube_colour, cube_face);
        expect_good(&report, &picture, &format!("computed {mode} fisheye"));
        let Some(same) = run.under("identity-captured") else { return };
        let same = same.expect_success().expect_no_gl_errors().picture("shot.ppm");
        expect_identical(&same, &plain, &format!("computed {mode} identity-captured"));
    }
}

/// One dispatch that samples the scene, loads from it, changes it or reads its depth. Its text may
/// also have matrices of the camera that it does not use. The result is drawn or blitted to the
/// window.
fn pictures_that_compute_shaders_make() {
    right(&["sampled", "stored", "same", "indirect", "depths", "declared", "pipeline", "blit"], Limits::USUAL);
    planetarium_of("computed", &["--mode", "sampled"], |run, rig| {
        Some(run.under(rig)?.expect_success().expect_no_gl_errors())
    });
}

/// Two dispatches with an image of half the size between them.
fn an_image_of_half_the_size() {
    right(&["half"], Limits::HALVED);
}

/// A sum over the picture, in a buffer, is the sum over the program's own picture.
fn sums_of_the_whole_picture_are_made_once() {
    right(&["exposure"], Limits::USUAL);
}

/// A compute shader that computes places from pixels gets the matrices of the view.
fn matrices_of_compute_shaders_are_those_of_the_view() {
    right(&["light"], Limits::USUAL);
    planetarium_of("computed", &["--mode", "light"], |run, rig| {
        Some(run.under(rig)?.expect_success().expect_no_gl_errors())
    });
}

/// A result that cannot be made for each view is flat, and the statistics say why. Such results are
/// values of each place in a buffer (also with atomic functions on other variables), images of
/// three dimensions, pictures that are changed together with a buffer, and sums in an image
/// together with a picture.
fn values_of_each_place_are_not_followed() {
    for mode in ["places", "tiles", "volume", "dots", "gathered"] {
        let extra = ["--mode", mode];
        let Some(finished) = run(&extra).under("fisheye") else { return };
        let finished = finished.expect_success().expect_no_gl_errors();
        let reasons = finished.statistics()["single_framebuffers"].to_string();
        assert!(reasons.contains("by compute shaders"), "{mode}: {reasons}");
        let lit = finished.picture("capture.png").pixels.iter().filter(|pixel| **pixel != [0; 3]).count();
        assert!(lit > 1000, "{mode}: {lit} pixels show something");
    }
}
