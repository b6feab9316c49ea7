//! Wide points and lines stay in their view: lit pixels are near the places where their colour was
//! drawn.

use crate::compare::expect_identical;
use crate::harness::tests;
use crate::picture::Picture;
use crate::programs::Run;
use crate::reference::{Fisheye, Vector, dot};

tests! {
    what_is_wider_than_the_gutter_is_cut_at_its_tile,
    smooth_lines_are_those_of_a_framebuffer_object,
}

/// Directions and colours of the marks of `tests/apps/outlines.c`, by number.
fn marks() -> Vec<(Vector, [f64; 3])> {
    (0..48_i32)
        .map(|i| {
            let (off, around) = (f64::from(10 + 10 * (i % 8)).to_radians(), f64::from(37 * i).to_radians());
            let direction = [off.sin() * around.cos(), off.sin() * around.sin(), -off.cos()];
            (direction, [0.3 + 0.1 * f64::from(i % 8), 0.3 + 0.1 * f64::from(i / 8), 0.4].map(|c| 255.0 * c))
        })
        .collect()
}

/// Number of pixels of marks, and number of those that are more than `apart` degrees from every
/// mark of their colour.
fn stray(picture: &Picture, apart: f64) -> (usize, usize) {
    let (width, height) = (picture.width as f64, picture.height as f64);
    let fisheye = Fisheye { width, height, aperture: 180.0, tilt: 90.0 };
    let marks = marks();
    let (mut lit, mut strays) = (0, 0);
    for y in 0..picture.height {
        for x in 0..picture.width {
            let found = picture.at(x, y).map(f64::from);
            let direction = fisheye.direction(x as f64 + 0.5, y as f64 + 0.5);
            let same = |colour: &[f64; 3]| colour.iter().zip(found).all(|(a, b)| (a - b).abs() < 3.0);
            let mut alike = marks.iter().filter(|(_, colour)| same(colour)).peekable();
            // Where marks meet, the filter mixes their colours. Only pixels of one mark identify
            // it.
            if alike.peek().is_some() {
                lit += 1;
                strays += usize::from(!alike.any(|(at, _)| dot(*at, direction) > apart.to_radians().cos()));
            }
        }
    }
    (lit, strays)
}

/// Greatest angle between a pixel and its mark: half the diagonal of a mark is 43 texels of a view,
/// of which 100 are a radian at 256 × 256. Some degrees are added for the mark's distance from the
/// axis.
const APART: f64 = 30.0;

fn what_is_wider_than_the_gutter_is_cut_at_its_tile() {
    let run = Run { yaw: 0.0, pitch: 0.0, ..Run::new("outlines") };
    let Some(finished) = run.under("fisheye") else { return };
    let picture = finished.expect_success().expect_no_gl_errors().picture("capture.png");
    let (lit, strays) = stray(&picture, APART);
    assert!(lit > 10_000, "only {lit} pixels are lit");
    // Where two marks meet, the mixture may have the colour of a third mark: 6 pixels. Without the
    // cut there are 1700.
    assert!(strays * 1000 <= lit, "of {lit} pixels {strays} lie where nothing of their colour was drawn");
    // Negative control: in the mirrored picture marks are at wrong places.
    let turned = Picture::from_fn(256, 256, |x, y| picture.at(255 - x, y));
    assert!(stray(&turned, APART).1 > lit / 2);
}

/// Mesa stores the rows of windows from the top and those of framebuffer objects from the bottom,
/// and its smooth lines are displaced by a tenth of a pixel in the direction of the rows. So lines
/// differ between a framebuffer object and the window of a program without Cupola, by up to 44 of
/// 255. Lines in a view are those of a framebuffer object.
fn smooth_lines_are_those_of_a_framebuffer_object() {
    let extra = ["--mode", "smooth", "--shot", "shot.ppm"];
    let run = Run { yaw: 0.0, pitch: 0.0, extra: &extra, ..Run::new("outlines") };
    let Some(in_view) = run.under("identity-captured") else { return };
    let in_view = in_view.expect_success().expect_no_gl_errors().picture("shot.ppm");
    let off_screen = ["--mode", "smooth", "--shot", "shot.ppm", "--fbo"];
    let Some(off_screen) = Run { extra: &off_screen, ..run.clone() }.plain() else { return };
    let off_screen = off_screen.expect_success().picture("shot.ppm");
    expect_identical(&in_view, &off_screen, "smooth lines in a view and in a framebuffer object");
    let lit = in_view.pixels.iter().filter(|pixel| **pixel != [0; 3]).count();
    assert!(lit > 1000, "{lit} pixels are lit");
}
