//! The Vulkan layer: a program that nobody changed, on the panel, and untouched by the rig `identity`.

use crate::compare::expect_identical;
use crate::picture::Picture;
use crate::programs::{Finished, installed};

const SIZE: &str = "300";

fn cube(rig: &str, more: &[&str]) -> Option<Finished> {
    let options = [&["--frames", "12", "--capture", "capture.png", "--stats", "stats.json"], more].concat();
    installed("vkcube", &["--width", SIZE, "--height", SIZE], rig, &options).map(Finished::expect_success)
}

/// The program draws into images of ours what it draws into the driver's.
#[test]
fn the_programs_picture_is_its_own() {
    let (Some(plain), Some(under)) = (cube("identity", &[]), cube("fisheye", &["--capture-views", "views"])) else {
        return;
    };
    expect_identical(&under.picture("views/program.png"), &plain.picture("capture.png"), "vkcube, its own picture");
    let statistics = under.statistics();
    assert_eq!(statistics["frames"].as_u64(), Some(12));
    assert!(statistics["driver"].as_str().is_some_and(|driver| driver.starts_with("Vulkan")), "{statistics:#}");
    assert!(under.words().contains("flat"), "the log says what is done: {}", under.words());
}

/// Each pixel of the domemaster against the program's picture, from the definitions of the fisheye and the panel.
#[test]
fn the_panel_is_where_the_angles_say() {
    let Some(under) = cube("fisheye", &["--capture-views", "views"]) else { return };
    let (program, shown) = (under.picture("views/program.png"), under.picture("capture.png"));
    let (checked, wrong) = deviations(&program, &shown);
    assert!(checked > 5_000 && wrong == 0, "{wrong} of {checked} pixels are wrong");
    let turned =
        Picture::from_fn(shown.width, shown.height, |x, y| shown.pixels[(shown.height - 1 - y) * shown.width + x]);
    assert!(deviations(&program, &turned).1 > 100, "control: an upside-down picture is not taken for right");
}

/// Pixels that see the panel, and those of them that differ by more than 2/255 from any texel near their place.
fn deviations(program: &Picture, shown: &Picture) -> (usize, usize) {
    // The preset's panel is 60° wide.
    let half = 30_f64.to_radians().tan();
    let (length, whole) = (shown.width as f64, shown.width);
    let (mut checked, mut wrong) = (0, 0);
    for (at, pixel) in shown.pixels.iter().enumerate() {
        let (x, y) = (at % whole, at / whole);
        let (x, y) = ((2.0 * x as f64 + 1.0) / length - 1.0, (2.0 * y as f64 + 1.0) / length - 1.0);
        let radius = x.hypot(y);
        let angle = radius * std::f64::consts::FRAC_PI_2;
        if angle > 1.2 {
            continue;
        }
        let tangent = angle.tan() / radius.max(1e-9) / half;
        let place = [x, y].map(|part| (0.5 + 0.5 * part * tangent) * length - 0.5);
        if place.iter().any(|part| *part < 1.0 || *part > length - 2.0) {
            continue;
        }
        checked += 1;
        let [across, down] = place;
        let (left, top) = (across.floor() as usize, down.floor() as usize);
        let (part, under) = (across.fract(), down.fract());
        let texel = |x: usize, y: usize, channel: usize| f64::from(program.pixels[y * whole + x][channel]);
        wrong += usize::from((0..3).any(|channel| {
            let upper = texel(left, top, channel) * (1.0 - part) + texel(left + 1, top, channel) * part;
            let lower = texel(left, top + 1, channel) * (1.0 - part) + texel(left + 1, top + 1, channel) * part;
            (upper * (1.0 - under) + lower * under - f64::from(pixel[channel])).abs() > 2.0
        }));
    }
    (checked, wrong)
}
