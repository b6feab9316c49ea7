//! The light of all projectors together, on a white scene: the same everywhere.

use crate::picture::Picture;
use crate::programs::{Run, scratch};
use crate::reference::{Dome, Projector};
use crate::rigs;

const GAMMA: f64 = 2.2;

/// The light of a projector at a place of its picture, between its four nearest pixels.
fn light(picture: &Picture, [x, y]: [f64; 2], gamma: f64) -> f64 {
    let decoded = |x: f64, y: f64| {
        let column = x.clamp(0.0, picture.width as f64 - 1.0) as usize;
        let row = y.clamp(0.0, picture.height as f64 - 1.0) as usize;
        (f64::from(picture.at(column, row)[1]) / 255.0).powf(gamma)
    };
    let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
    let (u, v) = (x - 0.5 - left, y - 0.5 - top);
    let upper = (1.0 - u) * decoded(left, top) + u * decoded(left + 1.0, top);
    let lower = (1.0 - u) * decoded(left, top + 1.0) + u * decoded(left + 1.0, top + 1.0);
    (1.0 - v) * upper + v * lower
}

/// Least and greatest sum of light over the pixels of all projectors that shine on the screen.
fn extremes(projectors: &[Projector], dome: &Dome, pictures: &[Picture], gamma: f64) -> (f64, f64) {
    let mut extremes = (f64::INFINITY, f64::NEG_INFINITY);
    for projector in projectors {
        for row in 0..projector.height as usize {
            for column in 0..projector.width as usize {
                let Some(point) = projector.hit(dome, column as f64 + 0.5, row as f64 + 0.5) else { continue };
                // Half a pixel at the screen's rim may be lit in part.
                if dome.within_screen(point) < 1.0 {
                    continue;
                }
                let lights = projectors.iter().zip(pictures);
                let sum: f64 = lights
                    .filter_map(|(other, picture)| other.place(point).map(|place| light(picture, place, gamma)))
                    .sum();
                extremes = (extremes.0.min(sum), extremes.1.max(sum));
            }
        }
    }
    extremes
}

#[test]
fn the_summed_light_of_planetarium_6_is_uniform() {
    let (size, columns) = ((200, 150), 3);
    let mut rig = rigs::projectors("planetarium-6", size, columns);
    let file = scratch("rig").join("planetarium-6-small.toml");
    std::fs::write(&file, &rig.blended).expect("a rig can be written");
    let rows = rig.projectors.len().div_ceil(columns);
    let run = Run { size: (columns * size.0, rows * size.1), ..Run::new("white") };
    let Some(finished) = run.under(file.to_str().expect("a UTF-8 path")) else { return };
    let finished = finished.expect_success().expect_no_gl_errors();
    let pictures: Vec<Picture> =
        rig.projectors.iter().map(|projector| finished.picture(&format!("capture-{}.png", projector.name))).collect();
    let (least, greatest) = extremes(&rig.projectors, &rig.dome, &pictures, GAMMA);
    // The bar is 0.6 % in 8 bits; pictures this small add what interpolation between pixels loses.
    assert!(least > 0.985 && greatest < 1.015, "the summed light is {least:.4} to {greatest:.4}");

    // Negative controls: a wrong response, and a projector that stands elsewhere.
    let (least, greatest) = extremes(&rig.projectors, &rig.dome, &pictures, 1.8);
    assert!(greatest - least > 0.05, "a wrong gamma is not noticed: {least:.4} to {greatest:.4}");
    rig.projectors[0].turn.yaw += 2.0;
    let (least, greatest) = extremes(&rig.projectors, &rig.dome, &pictures, GAMMA);
    assert!(greatest - least > 0.05, "a turned projector is not noticed: {least:.4} to {greatest:.4}");
}
