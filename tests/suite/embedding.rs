//! A program that draws its own views, through the C interface.

use crate::compare::{Shown, compare, expect_good};
use crate::dialects::shown_by_fisheye;
use crate::programs::embedding;
use crate::reference::{Fisheye, ProgramCamera};

/// `embed` judges status codes, error texts, kept state and exact directions itself; its pictures are judged here.
#[test]
fn the_c_interface_without_a_window() {
    let camera = ProgramCamera { yaw: 33.0, pitch: -17.0 };
    let Some(finished) = embedding("embed", &["256", "33", "-17"]) else { return };
    let finished = finished.expect_success();
    for (file, size) in [("views.ppm", 256), ("callback.ppm", 192)] {
        let picture = finished.picture(file);
        assert_eq!((picture.width, picture.height), (size, size));
        let circle = Fisheye { width: size as f64, height: size as f64, aperture: 180.0, tilt: 90.0 };
        expect_good(&compare(&picture, shown_by_fisheye(circle, camera)), &picture, &format!("embed {file}"));
    }
    // The viewer has moved in the preset's dome of 5 m: each pixel is the same point of the dome, seen from there.
    let picture = finished.picture("moved.ppm");
    let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
    let moved = |[right, up, backward]: [f64; 3]| {
        move |x: f64, y: f64| match circle.inside_by(x, y) {
            ..0.0 => shown_by_fisheye(circle, camera)(x, y),
            _ => {
                let [a, b, c] = circle.direction(x, y);
                let seen = [5.0 * a - right, 5.0 * b - up, 5.0 * c - backward];
                let length = seen.iter().map(|part| part * part).sum::<f64>().sqrt();
                Shown::Direction(camera.to_world(seen.map(|part| part / length)))
            }
        }
    };
    expect_good(&compare(&picture, moved([2.0, -0.5, 1.0])), &picture, "embed moved.ppm");
    // Negative control: the old viewer's picture is another one.
    assert!(!compare(&picture, moved([0.0; 3])).good());
}
