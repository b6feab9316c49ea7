//! Vulkan programs whose compute shaders make the window's picture from an image of the scene.

use crate::compare::{Limits, Shown, compare_with, expect_good, expect_identical};
use crate::dialects::{CAMERAS, camera_of, planetarium_of, shown_by_fisheye, shown_by_window};
use crate::harness::tests;
use crate::picture::Picture;
use crate::programs::Run;
use crate::reference::{Fisheye, cube_colour, cube_face};

tests! {
    pictures_that_compute_shaders_make,
    several_dispatches_in_a_chain,
    numbers_of_the_whole_picture_are_gathered_once,
    matrices_of_compute_shaders_are_those_of_the_view,
    what_compute_shaders_made_is_copied_and_drawn_to,
    a_window_that_compute_shaders_write,
    values_of_each_place_are_not_followed,
}

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

fn run<'a>(extra: &'a [&'a str]) -> Run<'a> {
    let (fov, yaw, pitch) = CAMERAS[1];
    Run { fov, yaw, pitch, extra, frames: 6, ..Run::new("vk_computed") }
}

/// Each mode shows the predicted picture without Cupola and on a dome. With the program's own lens
/// it shows the same as without Cupola, to the byte.
fn right(modes: &[&str], limits: Limits) {
    for mode in modes {
        let extra = ["--mode", mode, "--shot", "shot.ppm"];
        let run = run(&extra);
        let compare = |picture: &Picture, shown: &dyn Fn(f64, f64) -> Shown, rig: &str| {
            let report = compare_with(picture, limits, shown, cube_colour, cube_face);
            expect_good(&report, picture, &format!("vk_computed {mode} {rig}"));
        };
        let Some(plain) = run.vulkan_plain() else { return };
        let plain = plain.expect_success().picture("shot.ppm");
        compare(&plain, &shown_by_window(run.size, run.fov, camera_of(&run)), "plain");
        let Some(under) = run.vulkan_under("fisheye") else { return };
        compare(&under.picture("capture.png"), &shown_by_fisheye(CIRCLE, camera_of(&run)), "fisheye");
        let Some(same) = run.vulkan_under("identity-captured") else { return };
        expect_identical(&same.picture("shot.ppm"), &plain, &format!("vk_computed {mode} identity-captured"));
    }
}

/// One dispatch between the scene and the window. It samples the scene, loads from it, writes to
/// the image that it reads, or reads its depth. It gets the picture's size from the image or from
/// push constants.
fn pictures_that_compute_shaders_make() {
    right(&["sampled", "stored", "same", "depths", "pushed", "descriptors", "indirect"], Limits::ROUNDED);
    planetarium_of("vk_computed", &["--mode", "sampled"], Run::vulkan_under);
}

/// Several dispatches, also with an image of half the size, with levels of one image, and with the
/// picture of the frame before.
fn several_dispatches_in_a_chain() {
    right(&["chain"], Limits::ROUNDED);
    right(&["history"], Limits::ROUNDED);
    right(&["half"], Limits::HALVED);
    right(&["levels"], Limits::COARSE);
}

/// Atomic sums over the whole picture, in a buffer, are those of the program's own picture.
fn numbers_of_the_whole_picture_are_gathered_once() {
    right(&["exposure"], Limits::ROUNDED);
}

/// A compute shader that computes places from pixels gets the matrices of the view.
fn matrices_of_compute_shaders_are_those_of_the_view() {
    right(&["light"], Limits::ROUNDED);
    planetarium_of("vk_computed", &["--mode", "light"], Run::vulkan_under);
}

/// The result of compute shaders is blitted to the window, or more is drawn to it before.
fn what_compute_shaders_made_is_copied_and_drawn_to() {
    right(&["blit", "copy", "drawn"], Limits::ROUNDED);
    planetarium_of("vk_computed", &["--mode", "blit"], Run::vulkan_under);
}

/// A shader without a declared format writes directly to the window's image.
fn a_window_that_compute_shaders_write() {
    right(&["written"], Limits::ROUNDED);
    planetarium_of("vk_computed", &["--mode", "written"], Run::vulkan_under);
}

/// A buffer has values of the program's own picture only. A picture that is made from them is flat,
/// and the statistics say why.
fn values_of_each_place_are_not_followed() {
    let run = run(&["--mode", "places"]);
    let Some(finished) = run.vulkan_under("fisheye") else { return };
    let reasons = finished.statistics()["single_framebuffers"].to_string();
    assert!(reasons.contains("read by compute shaders"), "{reasons}");
    let lit = finished.picture("capture.png").pixels.iter().filter(|pixel| **pixel != [0; 3]).count();
    assert!(lit > 1000, "{lit} pixels show something");
}
