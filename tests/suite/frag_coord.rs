//! Fragment shaders that read their place in the window. In a view it is the place in the view, as
//! if the view filled the window.

use crate::compare::{compare, expect_good};
use crate::dialects::{CAMERAS, camera_of, shown_by_fisheye, shown_by_window};
use crate::harness::tests;
use crate::picture::Picture;
use crate::programs::{Finished, Run};
use crate::reference::Fisheye;

tests! {
    what_is_cut_at_the_window_fills_the_dome,
    each_view_is_a_window,
    own_pictures_are_as_before,
    surfaces_with_edges,
}

const FORMS: [&str; 5] = ["core", "old", "upper", "pipeline", "off"];

fn run<'a>(extra: &'a [&'a str], cupola: &'a [&'a str]) -> Run<'a> {
    let (fov, yaw, pitch) = CAMERAS[1];
    Run { fov, yaw, pitch, extra, cupola, frames: 5, cupola_frames: 5, ..Run::new("frag_coord") }
}

fn finished(run: &Run, rig: &str) -> Option<Finished> {
    Some(run.under(rig)?.expect_success().expect_no_gl_errors())
}

/// The shader discards fragments beside the window.
fn what_is_cut_at_the_window_fills_the_dome() {
    for form in FORMS {
        let mode = format!("clip-{form}");
        let extra = ["--mode", &mode, "--shot", "shot.ppm"];
        let run = run(&extra, &[]);
        let Some(plain) = run.plain() else { return };
        let picture = plain.expect_success().picture("shot.ppm");
        expect_good(&compare(&picture, shown_by_window(run.size, run.fov, camera_of(&run))), &picture, &mode);
        let Some(under) = finished(&run, "fisheye") else { return };
        let picture = under.picture("capture.png");
        let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
        expect_good(&compare(&picture, shown_by_fisheye(circle, camera_of(&run))), &picture, &mode);
    }
}

/// Greatest difference of a view's colours from the places of its pixels, in 255ths. Places go from
/// `low` to 1.
fn worst(view: &Picture, low: f64) -> f64 {
    let place = |at: usize, length: usize| low + (1.0 - low) * (at as f64 + 0.5) / length as f64;
    let mut worst: f64 = 0.0;
    for y in 0..view.height {
        for x in 0..view.width {
            let expected = [place(x, view.width), place(view.height - 1 - y, view.height)];
            let found = view.at(x, y);
            for (found, expected) in found.iter().zip(expected) {
                worst = worst.max((f64::from(*found) - 255.0 * expected).abs());
            }
        }
    }
    worst
}

fn each_view_is_a_window() {
    for (form, low) in FORMS.into_iter().map(|form| (form, 0.0)).chain([("part", 0.5)]) {
        let mode = format!("gradient-{form}");
        let extra = ["--mode", &mode];
        let Some(under) = finished(&run(&extra, &["--capture-views", "views"]), "fisheye") else { return };
        let views = std::fs::read_dir(under.directory.join("views")).expect("views");
        let names = views.map(|file| file.expect("a file").file_name().to_string_lossy().into_owned());
        let names: Vec<String> = names.filter(|name| !name.contains("panel")).collect();
        assert!(names.len() > 2, "{mode}: {names:?}");
        for name in names {
            let worst = worst(&under.picture(&format!("views/{name}")), low);
            assert!(worst < 1.6, "{mode} {name}: off by {worst}/255");
        }
    }
}

/// The program's own picture stays the same to the byte.
fn own_pictures_are_as_before() {
    for mode in ["gradient-core", "gradient-upper", "gradient-part", "gradient-off"] {
        let extra = ["--mode", mode, "--shot", "shot.ppm"];
        let run = run(&extra, &[]);
        let Some(plain) = run.plain() else { return };
        let Some(under) = finished(&run, "identity-captured") else { return };
        let (plain, under) = (plain.expect_success().picture("shot.ppm"), under.picture("shot.ppm"));
        crate::compare::expect_identical(&under, &plain, mode);
    }
}

/// A geometry shader that computes places in the window from positions gets the places in the view,
/// as with `gl_FragCoord`.
fn surfaces_with_edges() {
    for (fov, yaw, pitch) in CAMERAS {
        let run = Run { fov, yaw, pitch, extra: &["--shot", "shot.ppm"], ..Run::new("edges") };
        let Some(plain) = run.plain() else { return };
        let picture = plain.expect_success().picture("shot.ppm");
        expect_good(&compare(&picture, shown_by_window(run.size, fov, camera_of(&run))), &picture, "edges plain");
        let Some(under) = finished(&run, "fisheye") else { return };
        let picture = under.picture("capture.png");
        let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
        expect_good(&compare(&picture, shown_by_fisheye(circle, camera_of(&run))), &picture, "edges fisheye");
    }
}
