//! Compares a picture with predicted directions.

use crate::harness::note;
use crate::picture::Picture;
use crate::programs::Finished;
use crate::reference::{Vector, cube_colour, cube_face};
use std::path::{Path, PathBuf};

/// Tolerances of a comparison. The fields are private, so that there are no other tolerances than
/// these constants. `docs/testing.md` lists them.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Greatest difference of a channel, in 255ths.
    tolerance: f64,
    /// Width of the zone along the cube's edges that is not compared, in pixels. Black pixels this
    /// near to others are not compared either.
    edge: f64,
    /// Whether pixels as near to black are not compared either. A filter may read cells that begin
    /// where nothing is shown any more.
    rim: bool,
}

impl Limits {
    /// Pictures whose texels are rounded once and that are sampled once. Worst value found: 1.93.
    pub const USUAL: Self = Self { tolerance: 2.0, edge: 1.5, rim: false };
    /// Tiles of different colours: the filter reads tiles that begin where nothing is shown. Worst
    /// value found: 1.40, and 4.44 without the zone along the rim.
    pub const TILES: Self = Self { rim: true, ..Self::USUAL };
    /// One more image between the scene and the window, which rounds its values again. The worst
    /// value found is 2.04 for an image of the window's size, 2.14 for one of twice the size.
    pub const ROUNDED: Self = Self { tolerance: 2.35, ..Self::USUAL };
    /// Primitives that are divided with an allowed error of one pixel. A pixel is up to 1.6/255
    /// wide. Worst value found: 2.37.
    pub const OF_ONE_PIXEL: Self = Self { tolerance: 2.5, ..Self::USUAL };
    /// An image of half the window's size that is filtered. Worst value found: 2.76.
    pub const HALVED: Self = Self { tolerance: 2.95, ..Self::USUAL };
    /// An image of half the window's size that is read without a filter, or levels of half the size
    /// that are made from each other. A texel is two pixels wide, which is up to 3.2/255. Worst
    /// value found: 3.28, and 3.71 nearer to the edges.
    pub const COARSE: Self = Self { tolerance: 3.5, edge: 3.0, rim: false };
}

/// Greatest difference of a pixel of a line from the colour of its place, in 255ths. A line is a
/// pixel wide, which is 1.6/255 at most, and the allowed error is half a pixel. Worst value found:
/// 2.53.
pub const LINES: f64 = 2.75;

/// Greatest difference of a point from the colour of its place, in 255ths. A point is drawn at the
/// pixel that contains its place: at most 0.7 pixels off the pixel's centre, each pixel 1.6/255 at
/// most. Worst value found: 2.15.
pub const POINTS: f64 = 2.35;

/// For [`expect_alike`]: outlines of lit surfaces, which the two pictures resample differently, in
/// 255ths. Worst value found: 9.
pub const OUTLINES: u8 = 9;

/// For [`expect_alike`]: borders of squares over the scene, which are blended once in the views and
/// once with the panel, in 255ths. Worst value found: 4.
pub const BORDERS: u8 = 4;

/// For [`expect_alike`]: edges of the cube in two pictures that both round their weights or that
/// have views of different sizes, in 255ths. Worst value found: 1.
pub const RESAMPLED: u8 = 1;

/// Least part of a picture that must be compared. Least value found: 0.638.
const LEAST_COMPARED: f64 = 0.62;

/// Least part of the pixels without light that must be compared. Least value found: 0.858.
const LEAST_BLACK: f64 = 0.85;

/// Expected content at a place of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shown {
    /// A direction of the world.
    Direction(Vector),
    /// Black, because nothing is shown there.
    Black,
    /// Not known: any colour is accepted.
    Unknown,
}

/// Result of a comparison.
pub struct Report {
    /// Pixels whose direction is known and that are far enough from edges.
    pub compared: usize,
    /// Number of compared pixels that are wrong.
    pub wrong: usize,
    /// Greatest difference of a channel, in 255ths.
    pub worst: f64,
    /// Column and row of the pixel with that difference.
    pub worst_at: (usize, usize),
    /// Pixels that should be black.
    pub dark: usize,
    /// Number of those pixels that are far enough from others to be compared.
    pub black: usize,
    /// Number of compared pixels that should be black and are not.
    pub lit: usize,
    /// Differences times 32, to look at.
    pub picture: Picture,
}

impl Report {
    /// Whether nothing is wrong and enough of the picture and of its black pixels were compared.
    pub fn good(&self) -> bool {
        let black = self.black as f64 >= LEAST_BLACK * self.dark as f64;
        self.wrong == 0 && self.lit == 0 && self.share() >= LEAST_COMPARED && black
    }

    /// Compared pixels as a part of all.
    pub fn share(&self) -> f64 {
        self.compared as f64 / self.picture.pixels.len() as f64
    }

    /// One line with the results.
    fn words(&self) -> String {
        let (x, y) = self.worst_at;
        format!(
            "{} of {} pixels ({:.1} % of the picture) are wrong, the worst by {:.2}/255 at column {x} row {y}; {} of \
             {} black pixels are lit, {} are near others",
            self.wrong,
            self.compared,
            100.0 * self.share(),
            self.worst,
            self.lit,
            self.black,
            self.dark - self.black
        )
    }
}

/// Compares every pixel with its expected colour. `shown` gives the direction at the pixel's centre
/// (in pixels from the top left), and `colour` gives the colour of that direction. A pixel is left
/// out if there is another `cell` within the `limits`.
pub fn compare_with(
    picture: &Picture,
    limits: Limits,
    shown: impl Fn(f64, f64) -> Shown,
    colour: impl Fn(Vector) -> Vector,
    cell: impl Fn(Vector) -> usize,
) -> Report {
    let surroundings = Surroundings::new((picture.width, picture.height), limits.edge, &shown, &cell);
    let mut report = Report {
        compared: 0,
        wrong: 0,
        worst: 0.0,
        worst_at: (0, 0),
        black: 0,
        dark: 0,
        lit: 0,
        picture: Picture::from_fn(picture.width, picture.height, |_, _| [0; 3]),
    };
    for y in 0..picture.height {
        for x in 0..picture.width {
            let found = picture.at(x, y);
            match surroundings.centre(x, y) {
                Shown::Unknown => {}
                Shown::Black => {
                    report.dark += 1;
                    if surroundings.all(x, y, |place| place == Kind::Black) {
                        report.black += 1;
                        report.lit += usize::from(found != [0; 3]);
                    }
                }
                Shown::Direction(direction) => {
                    let own = Kind::Cell(cell(direction));
                    let same = |place| match place {
                        Kind::Cell(_) => place == own,
                        Kind::Black => !limits.rim,
                        Kind::Unknown => true,
                    };
                    if !surroundings.all(x, y, same) {
                        continue;
                    }
                    let expected = colour(direction).map(|channel| 255.0 * channel);
                    let off = [0, 1, 2].map(|channel| (f64::from(found[channel]) - expected[channel]).abs());
                    let worst = off.into_iter().fold(0.0, f64::max);
                    report.compared += 1;
                    report.wrong += usize::from(worst > limits.tolerance);
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

/// [`Shown`] without the direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Cell(usize),
    Black,
    Unknown,
}

/// Content around each pixel's centre. If all pixel centres inside a circle have the same content,
/// so has the circle. Only otherwise the points of the circle itself are computed.
pub struct Surroundings<F, C> {
    shown: F,
    cell: C,
    /// Points around a pixel's centre that must have the same kind of content.
    ring: Vec<(f64, f64)>,
    /// Number of pixels beyond the picture's edges that `centres` and `kinds` contain.
    margin: usize,
    width: usize,
    centres: Vec<Shown>,
    kinds: Vec<Kind>,
}

impl<F: Fn(f64, f64) -> Shown, C: Fn(Vector) -> usize> Surroundings<F, C> {
    /// Prepares circles with a radius of `edge` pixels.
    pub fn new(size: (usize, usize), edge: f64, shown: F, cell: C) -> Self {
        let ring = (0..16)
            .map(|index| (f64::from(index) * std::f64::consts::TAU / 16.0).sin_cos())
            .flat_map(|(sin, cos)| [(edge * cos, edge * sin), (0.5 * edge * cos, 0.5 * edge * sin)])
            .collect();
        let margin = edge.ceil() as usize;
        let (width, height) = (size.0 + 2 * margin, size.1 + 2 * margin);
        let place = |index: usize| index as f64 - margin as f64 + 0.5;
        let centres: Vec<Shown> =
            (0..width * height).map(|index| shown(place(index % width), place(index / width))).collect();
        let mut this = Self { shown, cell, ring, margin, width, kinds: Vec::new(), centres };
        this.kinds = this.centres.iter().map(|centre| this.kind(*centre)).collect();
        this
    }

    fn kind(&self, shown: Shown) -> Kind {
        match shown {
            Shown::Direction(direction) => Kind::Cell((self.cell)(direction)),
            Shown::Black => Kind::Black,
            Shown::Unknown => Kind::Unknown,
        }
    }

    /// Content at a pixel's centre.
    pub fn centre(&self, x: usize, y: usize) -> Shown {
        self.centres[(y + self.margin) * self.width + x + self.margin]
    }

    /// Whether all points around a pixel's centre fulfil `condition`. The centre itself must fulfil
    /// it.
    pub fn all(&self, x: usize, y: usize, condition: impl Fn(Kind) -> bool) -> bool {
        let own = self.kinds[(y + self.margin) * self.width + x + self.margin];
        let side = 2 * self.margin + 1;
        let mut rows = self.kinds[y * self.width + x..].chunks(self.width).take(side);
        rows.all(|row| row[..side].iter().all(|kind| *kind == own)) || self.all_of_ring(x, y, condition)
    }

    /// As [`Self::all`], but computes the points of the circle in any case.
    pub fn all_of_ring(&self, x: usize, y: usize, condition: impl Fn(Kind) -> bool) -> bool {
        let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
        self.ring.iter().all(|(dx, dy)| condition(self.kind((self.shown)(x + dx, y + dy))))
    }
}

/// [`compare_with`] for the plain colour cube.
pub fn compare(picture: &Picture, shown: impl Fn(f64, f64) -> Shown) -> Report {
    compare_with(picture, Limits::USUAL, shown, cube_colour, cube_face)
}

/// Notes the results. Panics if the report is not good, and leaves the wrong picture and the
/// differences under target/.
pub fn expect_good(report: &Report, picture: &Picture, what: &str) {
    note(format_args!("{what}: {}", report.words()));
    if report.good() {
        return;
    }
    let (wrong, difference) = (failure_path(what, "picture"), failure_path(what, "difference"));
    picture.save(&wrong);
    report.picture.save(&difference);
    panic!("{what}: {}\n  picture    {}\n  difference {} (×32)", report.words(), wrong.display(), difference.display());
}

/// Panics if two pictures differ at all, and leaves both under target/.
pub fn expect_identical(found: &Picture, expected: &Picture, what: &str) {
    expect_similar(found, expected, 0, 0.0, what);
}

/// Panics if two runs did not capture the same outputs, or if the pictures differ at all.
pub fn expect_identical_captures(found: &Finished, expected: &Finished, what: &str) {
    let (found, expected) = (found.captures(), expected.captures());
    assert!(found.keys().eq(expected.keys()), "{what}: {:?} instead of {:?}", found.keys(), expected.keys());
    for ((name, found), expected) in found.iter().zip(expected.values()) {
        expect_identical(found, expected, &format!("{what}, {name}"));
    }
}

/// Panics if more than `part` of the pixels differ or if one of them differs by more than `step`,
/// and leaves both pictures under target/.
pub fn expect_similar(found: &Picture, expected: &Picture, step: u8, part: f64, what: &str) {
    let (count, worst) = found.difference(expected);
    note(format_args!("{what}: {count} pixels differ, the worst by {worst}/255"));
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

/// Part of the pixels of two pictures that differ by more than 4/255.
pub fn far(found: &Picture, expected: &Picture) -> f64 {
    let off = |i: &usize| (0..3).any(|c| found.pixels[*i][c].abs_diff(expected.pixels[*i][c]) > 4);
    (0..found.pixels.len()).filter(off).count() as f64 / found.pixels.len() as f64
}

/// Greatest distance of a channel of `found` from the range of that channel in `expected` within
/// `radius` pixels around. Returns it in 255ths, with the column and row of the pixel.
pub fn beyond_neighbours(found: &Picture, expected: &Picture, radius: usize) -> (u8, (usize, usize)) {
    assert_eq!((found.width, found.height), (expected.width, expected.height), "the pictures' sizes differ");
    let around = |at: usize, length: usize| at.saturating_sub(radius)..(at + radius + 1).min(length);
    let mut most = (0, (0, 0));
    for (x, y) in (0..found.height).flat_map(|y| (0..found.width).map(move |x| (x, y))) {
        let pixel = found.at(x, y);
        if pixel == expected.at(x, y) {
            continue;
        }
        let (mut low, mut high) = ([255; 3], [0; 3]);
        for row in around(y, found.height) {
            for column in around(x, found.width) {
                let near = expected.at(column, row);
                low = [0, 1, 2].map(|channel| near[channel].min(low[channel]));
                high = [0, 1, 2].map(|channel| near[channel].max(high[channel]));
            }
        }
        for channel in 0..3 {
            let beyond = low[channel].saturating_sub(pixel[channel]).max(pixel[channel].saturating_sub(high[channel]));
            if beyond > most.0 {
                most = (beyond, (x, y));
            }
        }
    }
    most
}

/// Panics if a pixel of either picture is more than `step` beyond the values of the other picture
/// within one pixel around, and leaves both under target/. Outlines may be displaced by a pixel,
/// but no pixel may show something else.
pub fn expect_alike(found: &Picture, expected: &Picture, step: u8, what: &str) {
    let [(there, at), (back, _)] = [beyond_neighbours(found, expected, 1), beyond_neighbours(expected, found, 1)];
    note(format_args!("{what}: {there}/255 at {at:?} and {back}/255 beyond the values around"));
    if there.max(back) > step {
        let paths = [failure_path(what, "picture"), failure_path(what, "expected")];
        found.save(&paths[0]);
        expected.save(&paths[1]);
        let [found, expected] = paths.map(|path| path.display().to_string());
        panic!("{what}: {there}/255 at {at:?}, {back}/255\n  picture  {found}\n  expected {expected}");
    }
}

/// Panics unless the points of the direction test's cube on `background` have the colours of their
/// places.
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
    note(format_args!("{lit} points, the worst is off by {worst:.2}/255"));
    assert!(lit > 8_000, "{lit} points are seen of about 12000");
    assert!(worst < POINTS, "a point is off by {worst:.2}/255");
}
