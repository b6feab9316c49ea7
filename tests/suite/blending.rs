//! The sum of the light of all projectors is the same everywhere for a white scene.

use crate::harness::tests;
use crate::picture::Picture;
use crate::programs::{Run, scratch};
use crate::reference::{Dome, Projector};
use crate::rigs;

tests! {
    the_light_of_planetarium_6_keeps_the_bar,
    small_pictures_add_up_and_wrong_ones_do_not,
}

const GAMMA: f64 = 2.2;

/// Light of a projector at a place of its picture, interpolated between the four nearest pixels.
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

/// Least and greatest sum of light, over every `step`-th pixel of each projector that lights the
/// screen.
fn extremes(projectors: &[Projector], dome: &Dome, pictures: &[Picture], gamma: f64, step: usize) -> (f64, f64) {
    let mut extremes = (f64::INFINITY, f64::NEG_INFINITY);
    for projector in projectors {
        let (width, height) = (projector.width as usize, projector.height as usize);
        for index in (0..width * height).step_by(step) {
            let (column, row) = (index % width, index / width);
            let Some(point) = projector.hit(dome, column as f64 + 0.5, row as f64 + 0.5) else { continue };
            // Pixels at the screen's rim may be lit only in part.
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
    extremes
}

/// Bound on the deviation of the summed light from 1 where at least one projector shines, with
/// pictures of 8 bits.
const BAR: f64 = 0.006;

/// The projectors have their full resolution. `cupola simulate` follows the viewer's rays and so
/// computes the light that an audience sees.
fn the_light_of_planetarium_6_keeps_the_bar() {
    let run = Run { cupola: &["--offscreen"], frames: 2, cupola_frames: 2, ..Run::new("white") };
    let Some(finished) = run.under("planetarium-6") else { return };
    let finished = finished.expect_success().expect_no_gl_errors();
    let answer = finished.simulate("planetarium-6", 512);
    let number = |name: &str| answer["uniformity"][name].as_f64().unwrap_or(f64::NAN);
    assert!(number("max") <= BAR && number("rms") <= BAR / 2.0, "{answer:#}");
    assert!((number("mean") - 1.0).abs() < 1e-3, "{answer:#}");
    // The circle without its rim, where pixels lie partly off the screen.
    let circle = std::f64::consts::FRAC_PI_4 * 512.0 * 512.0;
    assert!(number("pixels") > 0.99 * circle, "{answer:#}");

    // The same pictures, examined from the projectors' pixels without Cupola's geometry. The step
    // of 17 is coprime to the width of the pictures, so that all columns are examined.
    let rig = rigs::projectors("planetarium-6", (1920, 1080), 1);
    let pictures: Vec<Picture> =
        rig.projectors.iter().map(|projector| finished.picture(&format!("capture-{}.png", projector.name))).collect();
    let (least, greatest) = extremes(&rig.projectors, &rig.dome, &pictures, GAMMA, 17);
    assert!(least >= 1.0 - BAR && greatest <= 1.0 + BAR, "the summed light is {least:.5} to {greatest:.5}");

    // Negative control: a projector that is dimmed by two steps of 255.
    let mut dimmed = pictures;
    for pixel in &mut dimmed[0].pixels {
        *pixel = pixel.map(|channel| channel.saturating_sub(2));
    }
    let (least, _) = extremes(&rig.projectors, &rig.dome, &dimmed, GAMMA, 17);
    assert!(least < 1.0 - BAR, "a dimmed projector is not noticed: {least:.5}");
}

fn small_pictures_add_up_and_wrong_ones_do_not() {
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
    let (least, greatest) = extremes(&rig.projectors, &rig.dome, &pictures, GAMMA, 1);
    // The tolerance is wider here, because interpolation between the pixels of such small pictures
    // adds an error.
    assert!(least > 0.985 && greatest < 1.015, "the summed light is {least:.4} to {greatest:.4}");

    // Negative controls: a wrong response, and a projector that is turned.
    let (least, greatest) = extremes(&rig.projectors, &rig.dome, &pictures, 1.8, 1);
    assert!(greatest - least > 0.05, "a wrong gamma is not noticed: {least:.4} to {greatest:.4}");
    rig.projectors[0].turn.yaw += 2.0;
    let (least, greatest) = extremes(&rig.projectors, &rig.dome, &pictures, GAMMA, 1);
    assert!(greatest - least > 0.05, "a turned projector is not noticed: {least:.4} to {greatest:.4}");
}
