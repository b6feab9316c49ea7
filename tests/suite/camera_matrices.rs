//! Shaders that compute places of the scene from pixels, or pixels from places. Each view gets
//! matrices of its own.

use crate::compare::{compare, expect_good};
use crate::dialects::{CAMERAS, camera_of, shown_by_fisheye, shown_by_window};
use crate::harness::tests;
use crate::programs::{Finished, Run};
use crate::reference::Fisheye;

tests! {
    skies_are_where_they_belong,
    places_from_depth_are_those_of_the_scene,
    places_on_the_screen_are_the_view_s,
    own_pictures_are_the_program_s,
}

fn run<'a>(extra: &'a [&'a str]) -> Run<'a> {
    let (fov, yaw, pitch) = CAMERAS[1];
    Run { fov, yaw, pitch, extra, frames: 6, cupola_frames: 6, ..Run::new("camera_matrices") }
}

fn finished(run: &Run, rig: &str) -> Option<Finished> {
    Some(run.under(rig)?.expect_success().expect_no_gl_errors())
}

/// Each form shows what the reference predicts, without Cupola and on a dome.
fn right(forms: &[&str]) {
    for form in forms {
        let extra = ["--mode", form, "--shot", "shot.ppm"];
        let run = run(&extra);
        let Some(plain) = run.plain() else { return };
        let picture = plain.expect_success().picture("shot.ppm");
        expect_good(&compare(&picture, shown_by_window(run.size, run.fov, camera_of(&run))), &picture, form);
        let Some(under) = finished(&run, "fisheye") else { return };
        let picture = under.picture("capture.png");
        let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
        let report = compare(&picture, shown_by_fisheye(circle, camera_of(&run)));
        expect_good(&report, &picture, &format!("{form} fisheye"));
    }
}

fn skies_are_where_they_belong() {
    right(&["sky_all", "sky_apart", "sky_inverted", "sky_row_vector", "sky_texture"]);
    right(&["sky_block", "sky_structure", "sky_vertices", "sky_old", "sky_off"]);
    right(&["sky_forced", "sky_forced_view"]);
}

fn places_from_depth_are_those_of_the_scene() {
    right(&["light_all", "light_apart", "light_texture", "light_back"]);
    right(&["light_copied", "light_converted"]);
}

fn places_on_the_screen_are_the_view_s() {
    right(&["place_all", "place_shared", "place_texture", "place_geometry", "place_lamp"]);
}

/// The program's own picture stays the same to the byte.
fn own_pictures_are_the_program_s() {
    for form in ["sky_all", "sky_vertices", "sky_inverted", "light_apart"] {
        let extra = ["--mode", form, "--shot", "shot.ppm"];
        let run = run(&extra);
        let Some(plain) = run.plain() else { return };
        let Some(under) = finished(&run, "identity-captured") else { return };
        let (plain, under) = (plain.expect_success().picture("shot.ppm"), under.picture("shot.ppm"));
        crate::compare::expect_identical(&under, &plain, form);
    }
}
