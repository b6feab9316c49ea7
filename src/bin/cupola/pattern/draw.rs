//! Pattern of one output, through its exact map.

mod shared;

use crate::canvas::{Canvas, Color, Letters};
use crate::failure::Failure;
use cupola::blend::Weights;
use cupola::rig::{OutputKind, Rig};
use cupola::warp::WarpMap;
use glam::{DMat3, DVec2, DVec3};

/// Part of a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Part {
    /// White everywhere
    White,
    /// Grey and colour ramps
    Ramps,
    /// Lines of one, two and four pixels, for sharpness
    Focus,
    /// Number of outputs that light each place: grey one, green two, blue three, red more
    Overlap,
    /// Lines on which two outputs share the light equally
    Seams,
    /// Grid of azimuth and elevation
    Horizon,
    /// Grid of angles from the dome's pole and around it
    Dome,
    /// Border, diagonals, number, name and size
    Border,
}

const HORIZON: Color = [0.2, 0.9, 0.3];
const DOME: Color = [0.3, 0.7, 1.0];
const AXIS: Color = [1.0, 0.85, 0.2];
const CROSS: Color = [1.0, 0.2, 0.2];
const WHITE: Color = [1.0; 3];

/// Half of the lines' width, pixels.
const HALF: f64 = 0.75;
/// Distance of lines that are brighter and have labels, degrees.
const LABELLED: f64 = 30.0;
/// Length of the arms of a cross, radians.
const ARM: f64 = 0.09;

/// A pattern for a rig.
pub struct Pattern<'a> {
    rig: &'a Rig,
    maps: Vec<WarpMap>,
    /// Blend weights, if seams are drawn.
    weights: Option<Weights<'a>>,
    parts: &'a [Part],
    /// Distance of lines, degrees.
    step: f64,
    /// Directions of crosses: unit vectors, dome axes.
    crosses: Vec<DVec3>,
}

impl<'a> Pattern<'a> {
    /// Makes a pattern for outputs of these sizes; `step` and the azimuth and elevation of crosses
    /// in degrees.
    pub fn new(
        rig: &'a Rig,
        sizes: &[(u32, u32)],
        parts: &'a [Part],
        step: f64,
        crosses: &[[f64; 2]],
    ) -> Result<Self, Failure> {
        let maps = sizes.iter().enumerate().map(|(index, size)| WarpMap::new(rig, index, *size, None));
        let crosses = crosses.iter().map(|[azimuth, elevation]| towards(*azimuth, *elevation)).collect();
        let weights = parts.contains(&Part::Seams).then(|| Weights::new(rig, sizes)).transpose()?;
        Ok(Self { rig, maps: maps.collect::<Result<_, _>>()?, weights, parts, step, crosses })
    }

    /// Draws the picture of an output.
    pub fn draw(&self, index: usize) -> Canvas {
        let (width, height) = self.maps[index].size();
        let mut canvas = Canvas::new(width as usize, height as usize, [0.0; 3]);
        canvas.mirrors_text = self.is_mirrored(index);
        let needs_directions = self.parts.iter().any(|part| matches!(part, Part::Horizon | Part::Dome));
        let directions = if needs_directions || !self.crosses.is_empty() { self.directions(index) } else { Vec::new() };
        for part in self.parts {
            match part {
                Part::White => canvas.fill(|_, _| WHITE),
                Part::Ramps => ramps(&mut canvas),
                Part::Focus => focus(&mut canvas),
                Part::Overlap => self.overlap(index, &mut canvas),
                Part::Seams => self.seams(index, &mut canvas),
                Part::Horizon => self.grid(index, &directions, DMat3::IDENTITY, HORIZON, &mut canvas),
                // These axes have the pole at the top and the front ahead.
                Part::Dome => {
                    let axes = DMat3::from_rotation_x(self.rig.dome.tilt);
                    self.grid(index, &directions, axes, DOME, &mut canvas);
                }
                Part::Border => self.border(index, &mut canvas),
            }
        }
        for cross in &self.crosses {
            self.cross(index, &directions, *cross, &mut canvas);
        }
        canvas
    }

    /// Direction from the dome's centre to the point that a pixel lights, dome axes.
    fn direction(&self, index: usize, pixel: DVec2) -> Option<DVec3> {
        let map = &self.maps[index];
        match self.rig.outputs[index].kind {
            // The output has no place on the screen.
            OutputKind::Perspective { .. } => Some(map.viewer().rotation * map.direction(pixel)?),
            _ => map.hit(pixel)?.try_normalize(),
        }
    }

    /// True if the viewer sees the picture mirrored: by way of a mirror, or through a screen that is lit from behind.
    fn is_mirrored(&self, index: usize) -> bool {
        let (width, height) = self.maps[index].size();
        let turn = |part: (u32, u32)| -> Option<f64> {
            let at = DVec2::new(f64::from(width * part.0) / 4.0, f64::from(height * part.1) / 4.0);
            let [here, right, below] = [DVec2::ZERO, DVec2::X, DVec2::Y].map(|step| self.direction(index, at + step));
            let here = here?;
            Some(here.dot((right? - here).cross(below? - here)))
        };
        let places = (1..4).flat_map(|y| (1..4).map(move |x| (x, y)));
        places.filter_map(turn).map(f64::signum).sum::<f64>() < 0.0
    }

    /// Directions of all pixels and of one more column and row, row by row.
    fn directions(&self, index: usize) -> Vec<Option<DVec3>> {
        let (width, height) = self.maps[index].size();
        let centre = |column: u32, row: u32| DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
        let places = (0..=height).flat_map(|row| (0..=width).map(move |column| centre(column, row)));
        places.map(|place| self.direction(index, place)).collect()
    }

    /// Draws lines where `axes` times a direction has a multiple of the step as latitude or
    /// longitude.
    fn grid(&self, index: usize, directions: &[Option<DVec3>], axes: DMat3, color: Color, canvas: &mut Canvas) {
        let latitude = |d: DVec3| d.y.clamp(-1.0, 1.0).asin().to_degrees();
        let longitude = |d: DVec3| d.x.atan2(-d.z).to_degrees();
        let step = self.step;
        each_pixel(canvas, directions, |here, right, below| {
            let [here, right, below] = [here, right, below].map(|direction| axes * direction);
            // Around the poles the lines would merge into a blot.
            let crowded = here.x.hypot(here.z) < 0.04;
            let mut covered = [(0.0, color); 2];
            let angles = [
                (latitude(here), latitude(right), latitude(below)),
                (longitude(here), longitude(right), longitude(below)),
            ];
            for (slot, (angle, right, below)) in covered.iter_mut().zip(angles) {
                let nearest = (angle / step).round() * step;
                let slope = turned(right - angle).hypot(turned(below - angle));
                let brightness = if (nearest / LABELLED).fract().abs() < 1e-9 { 1.0 } else { 0.45 };
                let axis = nearest.abs() < 1e-9;
                *slot = (coverage(turned(angle - nearest).abs(), slope) * brightness, if axis { AXIS } else { color });
            }
            if crowded {
                covered[1].0 = 0.0;
            }
            covered
        });
        for (azimuth, elevation) in labelled() {
            let direction = axes.transpose() * towards(azimuth, elevation);
            // Angles of the dome count from its pole.
            let text = if axes == DMat3::IDENTITY {
                format!("{azimuth:.0}/{elevation:.0}")
            } else {
                format!("{:.0} at {azimuth:.0}", 90.0 - elevation)
            };
            if let Some(at) = self.place(index, direction) {
                canvas.label(&text, [at.x, at.y - 12.0], WHITE);
            }
        }
    }

    /// Place at which an output shows a direction from the dome's centre.
    fn place(&self, index: usize, direction: DVec3) -> Option<DVec2> {
        let map = &self.maps[index];
        let point = match self.rig.outputs[index].kind {
            OutputKind::Perspective { .. } => map.viewer().position + direction,
            _ => map.screen().unbounded_hit(DVec3::ZERO, direction)?.point,
        };
        map.pixel(point)
    }

    /// Draws two arcs that cross in a direction.
    fn cross(&self, index: usize, directions: &[Option<DVec3>], target: DVec3, canvas: &mut Canvas) {
        let right = DVec3::Y.cross(-target).try_normalize().unwrap_or(DVec3::X);
        let up = target.cross(-right);
        each_pixel(canvas, directions, |here, beside, below| {
            let place = |d: DVec3| DVec2::new(d.dot(right), d.dot(up)) / d.dot(target).max(1e-6);
            let (at, x, y) = (place(here), place(beside), place(below));
            let near = here.dot(target) > 0.5 && at.abs().max_element() < ARM;
            let line = |value: f64, by_x: f64, by_y: f64| {
                if near { coverage(value.abs(), (by_x - value).hypot(by_y - value)) } else { 0.0 }
            };
            [(line(at.x, x.x, y.x), CROSS), (line(at.y, x.y, y.y), CROSS)]
        });
        if let Some(at) = self.place(index, target) {
            let (azimuth, elevation) = (target.x.atan2(-target.z).to_degrees(), target.y.asin().to_degrees());
            canvas.label(&format!("{azimuth:.2}, {elevation:.2}"), [at.x, at.y + 16.0], CROSS);
        }
    }

    fn border(&self, index: usize, canvas: &mut Canvas) {
        let (width, height) = (canvas.width as f64, canvas.height as f64);
        let corners = [[0.5, 0.5], [width - 0.5, 0.5], [width - 0.5, height - 0.5], [0.5, height - 0.5]];
        for side in 0..4 {
            canvas.line(corners[side], corners[(side + 1) % 4], 1.0, WHITE);
        }
        canvas.line(corners[0], corners[2], 1.0, [0.35; 3]);
        canvas.line(corners[1], corners[3], 1.0, [0.35; 3]);
        let output = &self.rig.outputs[index];
        let text = format!("{}  {}  {} × {}", index + 1, output.name, canvas.width, canvas.height);
        canvas.heading(&text, [0.5 * width, 0.5 * height], Letters::Large, WHITE);
    }
}

/// Unit vector of an azimuth and an elevation in degrees.
fn towards(azimuth: f64, elevation: f64) -> DVec3 {
    let ((sine, cosine), (up, level)) = (azimuth.to_radians().sin_cos(), elevation.to_radians().sin_cos());
    DVec3::new(level * sine, up, -level * cosine)
}

/// Directions of labels: crossings of the lines of 30°.
fn labelled() -> impl Iterator<Item = (f64, f64)> {
    let elevations = (-2..=2).map(|step| LABELLED * f64::from(step));
    elevations.flat_map(|elevation| (-5..=6).map(move |step| (LABELLED * f64::from(step), elevation)))
}

/// Converts an angle in degrees to one in −180…180.
fn turned(angle: f64) -> f64 {
    angle - (angle / 360.0).round() * 360.0
}

/// Part of a pixel that a line covers. `distance` is that of the pixel's value from the line's;
/// values change by `slope` over a pixel.
fn coverage(distance: f64, slope: f64) -> f64 {
    // A discontinuity is no slope.
    if (1e-12..20.0).contains(&slope) { (HALF + 0.5 - distance / slope).clamp(0.0, 1.0) } else { 0.0 }
}

/// Blends two colours over each pixel that shows something, from the directions of the pixel, of
/// the next one to the right and of the next one below.
fn each_pixel(
    canvas: &mut Canvas,
    directions: &[Option<DVec3>],
    covered: impl Fn(DVec3, DVec3, DVec3) -> [(f64, Color); 2],
) {
    let (width, columns) = (canvas.width, canvas.width + 1);
    for (row, column) in (0..canvas.height).flat_map(|row| (0..width).map(move |column| (row, column))) {
        let at = row * columns + column;
        let Some(here) = directions[at] else { continue };
        // At the right and the lower side the pixel before serves as well.
        let beside = |next: usize, before: Option<usize>| {
            let mirrored = || Some(2.0 * here - directions[before?]?);
            directions[next].or_else(mirrored).unwrap_or(here)
        };
        let right = beside(at + 1, column.checked_sub(1).map(|_| at - 1));
        let below = beside(at + columns, row.checked_sub(1).map(|_| at - columns));
        for (part, color) in covered(here, right, below) {
            canvas.blend(column as i64, row as i64, color, part as f32);
        }
    }
}

/// Draws sixteen steps of grey, and a ramp of each primary and of all.
fn ramps(canvas: &mut Canvas) {
    let (width, height) = (canvas.width as f32, canvas.height as f32);
    canvas.fill(|x, y| {
        let (along, band) = ((x as f32 + 0.5) / width, (5.0 * (y as f32 + 0.5) / height) as usize);
        match band {
            0 => [(along * 16.0).floor().min(15.0) / 15.0; 3],
            1 => [along; 3],
            band => std::array::from_fn(|channel| if channel == band - 2 { along } else { 0.0 }),
        }
    });
}

/// Draws squares of upright, level and crossed lines of one, two and four pixels.
fn focus(canvas: &mut Canvas) {
    const FIELD: usize = 48;
    canvas.fill(|x, y| {
        let (column, row) = (x / FIELD, y / FIELD);
        let wide = [1, 2, 4][(column + row) % 3];
        let (upright, level) = (x / wide % 2 == 0, y / wide % 2 == 0);
        let lit = [upright, level, upright ^ level][(column + 2 * row) % 3];
        if lit { WHITE } else { [0.0; 3] }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn rig(text: &str) -> Rig {
        cupola::rig::parse(text, "rig.toml", Path::new("")).expect("a rig")
    }

    fn brightness(canvas: &Canvas, x: f64, y: f64) -> f32 {
        canvas.at(x as usize, y as usize).iter().sum()
    }

    /// On a domemaster with the zenith in its middle, an elevation is a circle, whose radius
    /// decreases evenly.
    #[test]
    fn lines_are_where_the_closed_form_says() {
        let rig = rig("[[output]]\nkind = \"domemaster\"\n");
        let parts = [Part::Horizon];
        let pattern = Pattern::new(&rig, &[(400, 400)], &parts, 10.0, &[]).expect("a pattern");
        let canvas = pattern.draw(0);
        for (elevation, azimuth) in [(20.0, 15.0_f64), (40.0, 75.0), (40.0, -105.0)] {
            let (sine, cosine) = azimuth.to_radians().sin_cos();
            let at = |elevation: f64| {
                let radius = 200.0 * (90.0 - elevation) / 90.0;
                // The front is at the bottom. One of the pixels around the place has the line.
                let around = (-1..=1).flat_map(|x| (-1..=1).map(move |y| (f64::from(x), f64::from(y))));
                let (x, y) = (200.0 + radius * sine, 200.0 + radius * cosine);
                around.map(|(by_x, by_y)| brightness(&canvas, x + by_x, y + by_y)).fold(0.0, f32::max)
            };
            assert!(at(elevation) > 0.3, "{elevation}: {}", at(elevation));
            assert!(at(elevation + 5.0) == 0.0, "{elevation}: {}", at(elevation + 5.0));
        }
        // Outside the circle the picture stays dark.
        assert_eq!(brightness(&canvas, 2.0, 2.0), 0.0);
    }

    #[test]
    fn a_cross_is_in_its_direction_on_every_output() {
        let text = "[dome]\ntilt = 20\n[[output]]\nkind = \"projector\"\nposition = [0, 0, 1]\npitch = 30\nfov = [80, 60]\n\
            [[output]]\nkind = \"equirectangular\"\n[[output]]\nkind = \"perspective\"\nfov = [90, 90]\npitch = 30\n";
        let rig = rig(text);
        let (sizes, crosses) = ([(320, 240), (720, 360), (200, 200)], [[12.0, 34.0]]);
        let pattern = Pattern::new(&rig, &sizes, &[], 10.0, &crosses).expect("a pattern");
        for index in 0..3 {
            let at = pattern.place(index, towards(12.0, 34.0)).expect("it is shown");
            let canvas = pattern.draw(index);
            assert!(brightness(&canvas, at.x, at.y) > 0.8, "{index}: {at}");
            let lit = |x: f64, y: f64| canvas.at(x as usize, y as usize)[0] > 0.4;
            assert!(!lit(at.x + 7.0, at.y - 7.0), "{index}");
        }
        // By hand: longitude across, latitude up.
        let at = pattern.place(1, towards(12.0, 34.0)).expect("it is shown");
        assert!(
            (at.x - 720.0 * (0.5 + 12.0 / 360.0)).abs() < 1e-6 && (at.y - 360.0 * (0.5 - 34.0 / 180.0)).abs() < 1e-6
        );
    }

    /// The viewer of a mirror dome reads the labels, as those of all others do.
    #[test]
    fn text_is_mirrored_where_the_viewer_sees_it_in_a_mirror() {
        let mirrored = |name: &str| {
            let rig = cupola::rig::load(name).expect("a preset");
            let sizes = vec![(192, 108); rig.outputs.len()];
            let pattern = Pattern::new(&rig, &sizes, &[], 10.0, &[]).expect("a pattern");
            (0..rig.outputs.len()).map(|index| pattern.is_mirrored(index)).collect::<Vec<_>>()
        };
        assert_eq!(mirrored("idome"), [true]);
        assert_eq!(mirrored("planetarium-6"), [false; 6]);
        assert_eq!(mirrored("fisheye"), [false]);
        let letters = |mirrors_text: bool| {
            let mut canvas = Canvas::new(20, 20, [0.0; 3]);
            canvas.mirrors_text = mirrors_text;
            canvas.text("F", 2, 2, Letters::Small, WHITE);
            (0..20).map(|x| (0..20).map(|y| canvas.at(x, y)[0]).sum::<f32>()).collect::<Vec<f32>>()
        };
        let inked = |mirrors: bool| letters(mirrors).into_iter().filter(|sum| *sum > 0.0).collect::<Vec<f32>>();
        let (plain, mut other) = (inked(false), inked(true));
        assert_ne!(plain, other);
        other.reverse();
        assert_eq!(plain, other);
    }

    #[test]
    fn overlaps_are_counted() {
        let text = "[[output]]\nkind = \"projector\"\npitch = 30\nyaw = -20\nfov = [60, 40]\n\
            [[output]]\nkind = \"projector\"\npitch = 30\nyaw = 20\nfov = [60, 40]\n";
        let rig = rig(text);
        let parts = [Part::Overlap];
        let pattern = Pattern::new(&rig, &[(160, 96); 2], &parts, 10.0, &[]).expect("a pattern");
        let left = pattern.draw(0);
        assert_eq!(left.at(4, 48), [0.25; 3]);
        assert_eq!(left.at(150, 48), [0.1, 0.45, 0.15]);
    }

    #[test]
    fn steps_of_grey_are_even() {
        let mut canvas = Canvas::new(160, 50, [0.0; 3]);
        ramps(&mut canvas);
        let codes: Vec<u8> = (0..16).map(|step| (canvas.at(step * 10 + 5, 2)[1] * 255.0 + 0.5) as u8).collect();
        assert_eq!(codes, (0..16).map(|step| step * 17).collect::<Vec<u8>>());
    }
}
