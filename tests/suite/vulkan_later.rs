//! Vulkan programs whose later passes read the scene: by places on the screen, its depth, or images
//! of other sizes.

use crate::compare::{Limits, Shown, compare_with, expect_good, expect_identical};
use crate::dialects::{CAMERAS, camera_of, planetarium_of, shown_by_fisheye, shown_by_window};
use crate::harness::tests;
use crate::picture::Picture;
use crate::programs::Run;
use crate::reference::{Fisheye, cube_colour, cube_face};

tests! {
    passes_that_read_the_scene_by_places_on_the_screen,
    passes_that_read_the_depth_of_the_scene,
    images_of_other_sizes,
    skies_are_where_they_belong,
    places_from_depth_are_those_of_the_scene,
}

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

fn run<'a>(extra: &'a [&'a str]) -> Run<'a> {
    let (fov, yaw, pitch) = CAMERAS[1];
    Run { fov, yaw, pitch, extra, frames: 6, ..Run::new("vk_later_passes") }
}

/// Each mode shows the predicted picture without Cupola and on a dome. With the program's own lens
/// it shows the same as without Cupola, to the byte.
fn right(modes: &[&str], limits: Limits) {
    for mode in modes {
        let extra = ["--mode", mode, "--shot", "shot.ppm"];
        let run = run(&extra);
        let compare = |picture: &Picture, shown: &dyn Fn(f64, f64) -> Shown, rig: &str| {
            let report = compare_with(picture, limits, shown, cube_colour, cube_face);
            expect_good(&report, picture, &format!("vk_later_passes {mode} {rig}"));
        };
        let Some(plain) = run.vulkan_plain() else { return };
        let plain = plain.expect_success().picture("shot.ppm");
        compare(&plain, &shown_by_window(run.size, run.fov, camera_of(&run)), "plain");
        let Some(under) = run.vulkan_under("fisheye") else { return };
        compare(&under.picture("capture.png"), &shown_by_fisheye(CIRCLE, camera_of(&run)), "fisheye");
        let Some(same) = run.vulkan_under("identity-captured") else { return };
        expect_identical(&same.picture("shot.ppm"), &plain, &format!("vk_later_passes {mode} identity-captured"));
    }
}

/// A shader that reads the scene at a place that it computes from its own place on the screen reads
/// the same place of the view.
fn passes_that_read_the_scene_by_places_on_the_screen() {
    right(&["fetch", "divided", "given", "handed", "late"], Limits::USUAL);
    planetarium_of("vk_later_passes", &["--mode", "fetch"], Run::vulkan_under);
}

/// If a later pass reads the scene's depth, alone or with two colour images, the depth is drawn for
/// each view.
fn passes_that_read_the_depth_of_the_scene() {
    right(&["deferred", "depths", "volume", "prepass"], Limits::USUAL);
    planetarium_of("vk_later_passes", &["--mode", "deferred"], Run::vulkan_under);
}

/// Images of half or twice the window's size have half or twice the size of each view.
fn images_of_other_sizes() {
    right(&["double", "double_fetch", "double_blit", "double_depths", "chain"], Limits::ROUNDED);
    right(&["half", "half_blit", "blit_half"], Limits::HALVED);
    right(&["half_fetch"], Limits::COARSE);
}

/// A triangle over the window. Its shader computes a direction with an inverse of the camera's
/// matrix in a block, and from it the colour.
fn skies_are_where_they_belong() {
    right(&["sky", "sky_rows", "sky_inverted", "sky_columns", "sky_vertices"], Limits::USUAL);
    right(&["sky_apart", "sky_forced"], Limits::USUAL);
    planetarium_of("vk_later_passes", &["--mode", "sky"], Run::vulkan_under);
}

/// Places that are computed from pixels and depth, and pixels that are computed from places, are
/// those of the view.
fn places_from_depth_are_those_of_the_scene() {
    right(&["light", "light_back", "place"], Limits::USUAL);
    planetarium_of("vk_later_passes", &["--mode", "light"], Run::vulkan_under);
}
