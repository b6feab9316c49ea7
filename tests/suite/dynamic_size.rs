//! Scenes in a part of an image, as with a dynamic resolution, and several scenes side by side.

use crate::compare::{Limits, compare_with, expect_good, expect_identical};
use crate::dialects::{camera_of, shown_by_fisheye};
use crate::harness::tests;
use crate::programs::{Finished, Run};
use crate::reference::{Fisheye, cube_colour, cube_face};

tests! {
    a_part_of_an_image_holds_the_scene,
    a_part_of_an_image_holds_the_scene_of_vulkan,
    scenes_side_by_side_are_on_the_panel,
}

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

fn expect_scene(finished: &Finished, run: &Run<'_>, limits: Limits, what: &str) {
    let picture = finished.picture("capture.png");
    let report = compare_with(&picture, limits, shown_by_fisheye(CIRCLE, camera_of(run)), cube_colour, cube_face);
    expect_good(&report, &picture, what);
}

/// The part has 0.4 or 0.8 of the image's width, or changes in each frame. A draw or a blit shows it.
fn a_part_of_an_image_holds_the_scene() {
    for mode in ["small", "most", "changing", "blit"] {
        let extra = ["--mode", mode, "--shot", "shot.ppm"];
        let run = Run { extra: &extra, frames: 6, cupola_frames: 6, ..Run::new("dynamic_size") };
        let (Some(under), Some(own)) = (run.under("fisheye"), run.under("identity-captured")) else { return };
        let limits = if mode == "most" { Limits::USUAL } else { Limits::COARSE };
        expect_scene(&under.expect_success().expect_no_gl_errors(), &run, limits, &format!("dynamic_size {mode}"));
        // The shots of two runs may be of different frames.
        if mode == "changing" {
            continue;
        }
        let own = own.expect_success().expect_no_gl_errors().picture("shot.ppm");
        let Some(plain) = run.plain() else { return };
        expect_identical(&own, &plain.expect_success().picture("shot.ppm"), mode);
    }
}

fn a_part_of_an_image_holds_the_scene_of_vulkan() {
    for way in ["small", "most"] {
        let extra = ["--way", way, "--shot", "shot.ppm"];
        let run = Run { extra: &extra, frames: 8, ..Run::new("vk_scenes") };
        let (Some(under), Some(own)) = (run.vulkan_under("fisheye"), run.vulkan_under("identity-captured")) else {
            return;
        };
        expect_scene(&under, &run, Limits::USUAL, &format!("vk_scenes {way}"));
        let Some(plain) = run.vulkan_plain() else { return };
        expect_identical(&own.picture("shot.ppm"), &plain.expect_success().picture("shot.ppm"), way);
    }
}

/// Four scenes in the quarters of an image are flat, and beside the panel is the colour of the clear.
fn scenes_side_by_side_are_on_the_panel() {
    let run = Run { extra: &["--mode", "quarters"], frames: 6, cupola_frames: 6, ..Run::new("dynamic_size") };
    let Some(under) = run.under("fisheye") else { return };
    let picture = under.expect_success().expect_no_gl_errors().picture("capture.png");
    for (x, y) in [(30, 128), (226, 128), (128, 30), (128, 226), (60, 60)] {
        assert_eq!(picture.at(x, y), [64; 3], "({x}, {y})");
    }
    // The middle of each quarter has the colour of the cube there, ahead of the camera.
    let ahead = [(108, 108), (148, 108), (108, 148), (148, 148)].map(|(x, y)| picture.at(x, y));
    for quarter in &ahead[1..] {
        let far = quarter.iter().zip(ahead[0]).map(|(a, b)| a.abs_diff(b)).max();
        assert!(far < Some(40), "{ahead:?}");
    }
}
