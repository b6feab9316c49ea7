//! Pictures of the results: plots of time against error, and maps of the errors.

use super::contest::{Contest, Outcome};
use crate::failure::Failure;
use std::fmt::Write;
use std::path::Path;

/// Width and height of a plot in pixels.
const SIZE: (f64, f64) = (1280.0, 600.0);
/// Left, top, right and bottom of the area with the points.
const AREA: [f64; 4] = [80.0, 50.0, 880.0, 540.0];
/// Line height of the list of names.
const LINE: f64 = 16.0;
/// Lower limit of plotted errors in pixels.
const LEAST_ERROR: f64 = 1e-5;
/// The error with the strongest colour in error maps, in pixels.
const WORST_SHOWN: f64 = 10.0;

/// A method with its time and its greatest error.
type Point<'a> = (&'a Outcome, f64, f64);

/// Logarithmic axes of time and error: lowest and highest value.
struct Axes {
    times: (f64, f64),
    errors: (f64, f64),
}

impl Axes {
    fn of(points: &[Point]) -> Self {
        let range = |of: fn(&Point) -> f64| {
            let low = points.iter().map(of).fold(f64::INFINITY, f64::min);
            let high = points.iter().map(of).fold(0.0, f64::max);
            (0.8 * low, 1.3 * high)
        };
        Self { times: range(|point| point.1), errors: range(|point| point.2) }
    }

    fn x(&self, time: f64) -> f64 {
        let [left, _, right, _] = AREA;
        left + (right - left) * part(time, self.times)
    }

    fn y(&self, error: f64) -> f64 {
        let [_, top, _, bottom] = AREA;
        bottom - (bottom - top) * part(error, self.errors)
    }

    /// Writes lines with their numbers.
    fn grid(&self, svg: &mut String) -> std::fmt::Result {
        let [left, top, right, bottom] = AREA;
        for error in
            (-5..5).map(|power| 10f64.powi(power)).filter(|error| (self.errors.0..self.errors.1).contains(error))
        {
            writeln!(
                svg,
                "<path d=\"M{left} {0:.1}H{right}\" stroke=\"#ddd\"/><text x=\"{1}\" y=\"{2:.1}\" text-anchor=\"end\">{error}</text>",
                self.y(error),
                left - 6.0,
                self.y(error) + 4.0
            )?;
        }
        for time in [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0]
            .into_iter()
            .filter(|t| (self.times.0..self.times.1).contains(t))
        {
            writeln!(
                svg,
                "<path d=\"M{0:.1} {top}V{bottom}\" stroke=\"#ddd\"/><text x=\"{0:.1}\" y=\"{1}\" text-anchor=\"middle\">{time}</text>",
                self.x(time),
                bottom + 18.0
            )?;
        }
        Ok(())
    }
}

/// Position of a value between the ends of a range on a logarithmic scale, 0…1.
fn part(value: f64, (low, high): (f64, f64)) -> f64 {
    (value / low).ln() / (high / low).ln()
}

/// Times and errors of those methods than which no other is both faster and more exact, by time.
fn front(points: &[Point]) -> Vec<(f64, f64)> {
    let mut front: Vec<(f64, f64)> = points.iter().map(|point| (point.1, point.2)).collect();
    front.retain(|(time, error)| {
        !points.iter().any(|other| other.1 <= *time && other.2 < *error || other.1 < *time && other.2 <= *error)
    });
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    front
}

/// An SVG plot of time against greatest error, both logarithmic. Methods are numbered by their
/// time.
pub fn scatter(contest: &Contest) -> String {
    let mut points: Vec<Point> = contest
        .results
        .iter()
        .filter_map(|result| Some((result, result.ratio, result.error.as_ref()?.map.max.max(LEAST_ERROR))))
        .collect();
    points.sort_by(|a, b| a.1.total_cmp(&b.1));
    let axes = Axes::of(&points);
    let [left, top, right, bottom] = AREA;
    let (width, height) = SIZE;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n\
         <text x=\"{left}\" y=\"24\" font-size=\"16\">{}, {} × {}: run time against greatest error</text>\n",
        contest.scene.name, contest.scene.size.0, contest.scene.size.1
    );
    // Writing into a string cannot fail.
    let _ = axes.grid(&mut svg);
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">time, in units of one bilinear picture</text>\n\
         <text transform=\"translate(20 {}) rotate(-90)\" text-anchor=\"middle\">greatest error, pixels</text>",
        0.5 * (left + right),
        height - 18.0,
        0.5 * (top + bottom)
    );
    let line: Vec<String> =
        front(&points).iter().map(|(time, error)| format!("{:.1} {:.1}", axes.x(*time), axes.y(*error))).collect();
    let _ = writeln!(svg, "<path d=\"M{}\" fill=\"none\" stroke=\"#2a6\" stroke-width=\"2\"/>", line.join("L"));
    for (index, (result, time, error)) in points.iter().enumerate() {
        let (at_x, at_y) = (axes.x(*time), axes.y(*error));
        let (color, radius) = if result.is_default { ("#d30", 7.0) } else { ("#36a", 4.5) };
        let name = result.name.replace('&', "&amp;").replace('<', "&lt;");
        let _ = writeln!(
            svg,
            "<circle cx=\"{at_x:.1}\" cy=\"{at_y:.1}\" r=\"{radius}\" fill=\"{color}\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\">{number}</text>\
             <text x=\"{:.1}\" y=\"{:.1}\" fill=\"{color}\">{number}  {name}</text>",
            at_x + radius + 2.0,
            at_y - 3.0,
            right + 30.0,
            top + LINE * (index as f64 + 0.5),
            number = index + 1,
        );
    }
    svg.push_str("</svg>\n");
    svg
}

/// Writes a picture of the error of each method: dark is none, then blue, green, and red for ten
/// pixels and more; grey is nothing shown.
pub fn error_maps(contest: &Contest, directory: &Path) -> Result<(), Failure> {
    let (width, height) = contest.scene.size;
    let step = width.max(height).div_ceil(512).max(1);
    for (number, result) in contest.results.iter().enumerate() {
        let Some(error) = &result.error else { continue };
        let picture = image::RgbImage::from_fn(width / step, height / step, |x, y| {
            let at = |dx: u32, dy: u32| error.pixels[((y * step + dy) * width + x * step + dx) as usize];
            let worst = (0..step).flat_map(|dy| (0..step).map(move |dx| (dx, dy))).map(|(dx, dy)| at(dx, dy));
            image::Rgb(color(worst.fold(f32::NAN, f32::max)))
        });
        let path = directory.join(format!("{}-{number:02}.png", contest.scene.file_name()));
        let written = picture.save(&path);
        written.map_err(|error| Failure::new(format!("{} cannot be written: {error}", path.display())))?;
    }
    Ok(())
}

/// The colour of an error in pixels, on a logarithmic scale of six decades.
fn color(error: f32) -> [u8; 3] {
    if error.is_nan() {
        return [70; 3];
    }
    let part = (1.0 + (f64::from(error) / WORST_SHOWN).max(1e-6).log10() / 6.0).clamp(0.0, 1.0);
    let ramp = |middle: f64| (255.0 * (1.5 - (4.0 * (part - middle)).abs()).clamp(0.0, 1.0)) as u8;
    [ramp(0.9), ramp(0.6), ramp(0.3)]
}
