//! Place of the cube in pictures of `vkcube`, a Vulkan program by other authors.

use crate::picture::Picture;
use crate::programs::{Finished, installed};

/// Width and height of the window in these tests.
const SIZE: usize = 300;
/// Colour to which the program clears its window.
const GREY: [u8; 3] = [51; 3];
/// Squared distance of the eye, at (0, 3, 5), from the middle of a cube from −1 to 1.
const DISTANCE_SQUARED: f64 = 34.0;

/// Runs twelve frames of the program with the preset `fisheye`. `None` if that is not possible.
pub fn fisheye(more: &[&str]) -> Option<Finished> {
    let options =
        [&["--headless", "--frames", "12", "--capture", "capture.png", "--stats", "stats.json"], more].concat();
    let size = SIZE.to_string();
    installed("vkcube", &["--width", &size, "--height", &size], "fisheye", &options).map(Finished::expect_success)
}

/// Distances of two outlines from the picture's middle, in pixels: of the ball inside the cube and
/// of the ball around it.
fn outlines() -> (f64, f64) {
    let pixels = |sine_squared: f64| sine_squared.sqrt().asin() / std::f64::consts::FRAC_PI_2 * 0.5 * SIZE as f64;
    (pixels(1.0 / DISTANCE_SQUARED), pixels(3.0 / DISTANCE_SQUARED))
}

/// Number of pixels that show the cube. Returns an error unless a domemaster of 180° shows the cube
/// in its middle, however the cube is turned: the whole inner ball must be covered, and everything
/// beyond the outer ball must be grey.
pub fn cube(picture: &Picture) -> Result<usize, String> {
    if (picture.width, picture.height) != (SIZE, SIZE) {
        return Err(format!("{} × {} pixels", picture.width, picture.height));
    }
    let ((inner, outer), radius) = (outlines(), 0.5 * SIZE as f64);
    let (mut count, mut holes) = (0, 0);
    for (x, y) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y))) {
        let distance = (x as f64 + 0.5 - radius).hypot(y as f64 + 0.5 - radius);
        let found = picture.at(x, y);
        // A pixel of an outline or of the circle's rim may show either. The picture on the cube has
        // grey pixels, too.
        holes += usize::from(distance < inner - 1.0 && found == GREY);
        if distance > outer + 2.0 && distance < radius - 1.0 && found != GREY {
            return Err(format!("{found:?} beyond the cube at column {x} row {y}"));
        }
        if distance > radius + 1.0 && found != [0; 3] {
            return Err(format!("{found:?} beyond the circle at column {x} row {y}"));
        }
        count += usize::from(distance < outer + 2.0 && found != GREY);
    }
    if holes * 50 > count {
        return Err(format!("{holes} of {count} pixels of the cube show the room"));
    }
    Ok(count)
}

/// As [`cube`]. Panics if something is wrong.
pub fn expect_cube(picture: &Picture, what: &str) -> usize {
    cube(picture).unwrap_or_else(|error| panic!("{what}: {error}"))
}

/// Number of pixels that differ from all values of the other picture within a pixel around, as a
/// part of the cube's pixels. The picture on the cube has details of a pixel's size.
pub fn off(found: &Picture, expected: &Picture) -> f64 {
    assert!((found.width, found.height) == (SIZE, SIZE) && (expected.width, expected.height) == (SIZE, SIZE));
    let around = |x: usize, y: usize| (y - 1..=y + 1).flat_map(move |y| (x - 1..=x + 1).map(move |x| (x, y)));
    let is_off = |x: usize, y: usize| {
        (0..3).any(|channel| {
            let values = || around(x, y).map(|(x, y)| expected.at(x, y)[channel]);
            let (least, most) = (values().min().unwrap_or(0), values().max().unwrap_or(255));
            !(least.saturating_sub(16)..=most.saturating_add(16)).contains(&found.at(x, y)[channel])
        })
    };
    let inside = 1..SIZE - 1;
    let count = inside.clone().map(|y| inside.clone().filter(|x| is_off(*x, y)).count()).sum::<usize>();
    let cube = expected.pixels.iter().filter(|pixel| **pixel != GREY && **pixel != [0; 3]).count();
    count as f64 / cube as f64
}

/// For negative controls: a grey room with a white disc at the place of a cube.
pub fn disc(radius: f64, moved_by: f64) -> Picture {
    let middle = 0.5 * SIZE as f64;
    Picture::from_fn(SIZE, SIZE, |x, y| {
        let (x, y) = (x as f64 + 0.5 - middle, y as f64 + 0.5 - middle);
        match () {
            () if x.hypot(y) > middle => [0; 3],
            () if (x - moved_by).hypot(y) < radius => [255; 3],
            () => GREY,
        }
    })
}
