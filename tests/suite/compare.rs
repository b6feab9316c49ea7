//! Compares a picture with predicted directions.

use crate::picture::Picture;
use crate::reference::{Vector, cube_colour, cube_face};
use std::path::{Path, PathBuf};

/// Greatest difference of a channel, in 255ths.
pub const TOLERANCE: f64 = 2.0;
/// Pixels this near to an edge of the cube, and black ones this near to what is shown, are not compared.
pub const EDGE: f64 = 1.5;

/// What a comparison allows.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Greatest difference of a channel, in 255ths.
    pub tolerance: f64,
    /// Pixels this near to another cell are not compared.
    pub edge: f64,
    /// Nor those as near to black: a filter may read from cells that begin where nothing is shown any more.
    pub rim: bool,
}

impl From<f64> for Limits {
    /// The usual ones with this `edge`.
    fn from(edge: f64) -> Self {
        Self { tolerance: TOLERANCE, edge, rim: false }
    }
}

/// What a place in a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shown {
    /// A direction of the world.
    Direction(Vector),
    /// Black, because nothing is shown there.
    Black,
    /// Anything.
    Unknown,
}

/// What a comparison found.
pub struct Report {
    /// Pixels whose direction is known and that are far enough from edges.
    pub compared: usize,
    /// Those of them that are wrong.
    pub wrong: usize,
    /// Greatest difference of a channel, in 255ths.
    pub worst: f64,
    /// Where that is: column and row.
    pub worst_at: (usize, usize),
    /// Pixels that should be black.
    pub black: usize,
    /// Those of them that are not.
    pub lit: usize,
    /// Differences times 32, for people to look at.
    pub picture: Picture,
}

impl Report {
    /// Nothing is wrong, and enough was compared to say so.
    pub fn good(&self) -> bool {
        self.wrong == 0 && self.lit == 0 && self.compared * 2 > self.picture.pixels.len()
    }
}

/// Compares every pixel with the colour that `colour` gives to the direction that `shown` gives to the
/// pixel's centre (in pixels from the top left), unless there is another `cell` within the `limits`.
pub fn compare_with(
    picture: &Picture,
    limits: impl Into<Limits>,
    shown: impl Fn(f64, f64) -> Shown,
    colour: impl Fn(Vector) -> Vector,
    cell: impl Fn(Vector) -> usize,
) -> Report {
    let Limits { tolerance, edge, rim } = limits.into();
    let mut report = Report {
        compared: 0,
        wrong: 0,
        worst: 0.0,
        worst_at: (0, 0),
        black: 0,
        lit: 0,
        picture: Picture::from_fn(picture.width, picture.height, |_, _| [0; 3]),
    };
    // Places around a pixel's centre at which it must still be the same kind of thing.
    let ring: Vec<(f64, f64)> = (0..16)
        .map(|index| (f64::from(index) * std::f64::consts::TAU / 16.0).sin_cos())
        .flat_map(|(sin, cos)| [(edge * cos, edge * sin), (0.5 * edge * cos, 0.5 * edge * sin)])
        .collect();
    for y in 0..picture.height {
        for x in 0..picture.width {
            let (centre_x, centre_y) = (x as f64 + 0.5, y as f64 + 0.5);
            let mut around = ring.iter().map(|(dx, dy)| shown(centre_x + dx, centre_y + dy));
            let found = picture.at(x, y);
            match shown(centre_x, centre_y) {
                Shown::Unknown => {}
                Shown::Black => {
                    if around.all(|place| place == Shown::Black) {
                        report.black += 1;
                        report.lit += usize::from(found != [0; 3]);
                    }
                }
                Shown::Direction(direction) => {
                    let own = cell(direction);
                    let differs = |place| match place {
                        Shown::Direction(direction) => cell(direction) != own,
                        Shown::Black => rim,
                        Shown::Unknown => false,
                    };
                    if around.any(differs) {
                        continue;
                    }
                    let expected = colour(direction).map(|channel| 255.0 * channel);
                    let off = [0, 1, 2].map(|channel| (f64::from(found[channel]) - expected[channel]).abs());
                    let worst = off.into_iter().fold(0.0, f64::max);
                    report.compared += 1;
                    report.wrong += usize::from(worst > tolerance);
                    if worst > report.worst {
                        (report.worst, report.worst_at) = (worst, (x, y));
                    }
                    let index = y * picture.width + x;
                    report.picture.pixels[index] = off.map(|off| (32.0 * off).min(255.0) as u8);
                }
            }
        }
    }
    report
}

/// [`compare_with`] for the plain colour cube.
pub fn compare(picture: &Picture, shown: impl Fn(f64, f64) -> Shown) -> Report {
    compare_with(picture, EDGE, shown, cube_colour, cube_face)
}

/// Panics where the report is not good, and leaves the wrong picture and the differences under target/.
pub fn expect_good(report: &Report, picture: &Picture, what: &str) {
    if report.good() {
        return;
    }
    let (wrong, difference) = (failure_path(what, "picture"), failure_path(what, "difference"));
    picture.save(&wrong);
    report.picture.save(&difference);
    panic!(
        "{what}: {} of {} pixels are wrong, the worst by {:.1}/255 at column {} row {}; {} of {} black pixels are lit; \
         {} pixels in all\n  picture    {}\n  difference {} (×32)",
        report.wrong,
        report.compared,
        report.worst,
        report.worst_at.0,
        report.worst_at.1,
        report.lit,
        report.black,
        picture.pixels.len(),
        wrong.display(),
        difference.display()
    );
}

/// Panics where two pictures differ at all, and leaves both under target/.
pub fn expect_identical(found: &Picture, expected: &Picture, what: &str) {
    expect_similar(found, expected, 0, 0.0, what);
}

/// Panics where more than `part` of the pixels differ or one of them by more than `step`, and leaves both under target/.
pub fn expect_similar(found: &Picture, expected: &Picture, step: u8, part: f64, what: &str) {
    let (count, worst) = found.difference(expected);
    if worst <= step && count as f64 <= part * found.pixels.len() as f64 {
        return;
    }
    let paths = [failure_path(what, "picture"), failure_path(what, "expected")];
    found.save(&paths[0]);
    expected.save(&paths[1]);
    panic!(
        "{what}: {count} of {} pixels differ, the worst by {worst}/255\n  picture  {}\n  expected {}",
        found.pixels.len(),
        paths[0].display(),
        paths[1].display()
    );
}

fn failure_path(what: &str, kind: &str) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("suite-failures");
    std::fs::create_dir_all(&directory).expect("the folder for failures can be made");
    let name: String =
        what.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
    directory.join(format!("{name}-{kind}.png"))
}

/// How many pixels of two pictures differ by more than 4/255, as a part of all.
pub fn far(found: &Picture, expected: &Picture) -> f64 {
    let off = |i: &usize| (0..3).any(|c| found.pixels[*i][c].abs_diff(expected.pixels[*i][c]) > 4);
    (0..found.pixels.len()).filter(off).count() as f64 / found.pixels.len() as f64
}

/// Panics unless the points of the direction test's cube that are drawn on `background` have the colours of their places.
pub fn expect_points(picture: &Picture, background: [u8; 3], shown: impl Fn(f64, f64) -> Shown) {
    let (mut lit, mut worst) = (0, 0.0f64);
    for (x, y) in (0..picture.height).flat_map(|y| (0..picture.width).map(move |x| (x, y))) {
        let found = picture.at(x, y);
        let Shown::Direction(direction) = shown(x as f64 + 0.5, y as f64 + 0.5) else { continue };
        if found == background {
            continue;
        }
        lit += 1;
        let expected = cube_colour(direction).map(|channel| 255.0 * channel);
        let off = [0, 1, 2].map(|channel| (f64::from(found[channel]) - expected[channel]).abs());
        worst = worst.max(off.into_iter().fold(0.0, f64::max));
    }
    // A point is drawn at the pixel that its place is in: at most 0.7 pixels, each 1.6/255 at most, off its centre.
    assert!(lit > 8_000, "{lit} points are seen of about 12000");
    assert!(worst < 2.5, "a point is off by {worst:.2}/255");
}
