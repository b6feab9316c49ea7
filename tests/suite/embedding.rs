//! A program that draws its own views, through the C interface.

use crate::compare::{compare, expect_good};
use crate::dialects::shown_by_fisheye;
use crate::programs::embedding;
use crate::reference::{Fisheye, ProgramCamera};

/// `embed` judges status codes, error texts, kept state and exact directions itself; its pictures are judged here.
#[test]
fn the_c_interface_without_a_window() {
    let camera = ProgramCamera { yaw: 33.0, pitch: -17.0 };
    let Some(finished) = embedding("embed", &["256", "33", "-17"], &[]) else { return };
    let finished = finished.expect_success();
    for (file, size) in [("views.ppm", 256), ("callback.ppm", 192)] {
        let picture = finished.picture(file);
        assert_eq!((picture.width, picture.height), (size, size));
        let circle = Fisheye { width: size as f64, height: size as f64, aperture: 180.0, tilt: 90.0 };
        expect_good(&compare(&picture, shown_by_fisheye(circle, camera)), &picture, &format!("embed {file}"));
    }
}
