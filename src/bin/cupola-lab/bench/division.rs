//! Division of primitives whose vertices are projected directly to a picture: number of triangles
//! against error. Compares division by a bound on the error with division by fixed levels, as in
//! the recipe of 2014.

use super::contest::{quantile, sorted};
use cupola::geom::division::Weights;
use cupola::geom::lenses::picture_map::Place;
use cupola::geom::{Division, Face, PictureLens, PictureMap};
use glam::{DVec2, DVec3};
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::fmt::Write;
use std::time::Instant;

/// Results of one way to divide.
pub struct Outcome {
    /// Name of the method.
    pub name: String,
    /// True if triangles are divided by a bound on the error, not by fixed levels.
    pub bounded: bool,
    /// Number of triangles that are drawn for each triangle of the scene.
    pub parts: f64,
    /// Number of triangles that exceed the bound because the limit of divisions was reached.
    pub coarse: usize,
    /// Greatest error within the picture in pixels.
    pub greatest: f64,
    /// 99.9th percentile of the error in pixels.
    pub most: f64,
    /// Processor time for each triangle of the scene in microseconds.
    pub microseconds: f64,
}

/// Results for one picture.
pub struct Divided {
    /// Width and height in pixels.
    pub size: u32,
    /// Results of all ways to divide.
    pub outcomes: Vec<Outcome>,
}

/// Bounds on the error in pixels.
const BOUNDS: [f64; 5] = [4.0, 2.0, 1.0, 0.5, 0.25];
/// Numbers of fixed levels; the recipe of 2014 has three.
const LEVELS: [u32; 6] = [0, 1, 2, 3, 4, 5];
/// Number of cells along each edge of a wall.
const CELLS: u32 = 2;
/// Number of steps along an edge of a triangle between points at which the error is measured.
const PLACES: u32 = 6;

type Parts = Vec<[Weights; 3]>;

/// Divides the walls of a room for a fisheye of 180°. `quick`: with a quarter of the pixels.
pub fn run(quick: bool) -> Divided {
    let size = if quick { 1024 } else { 2048 };
    let pixels = DVec2::splat(f64::from(size));
    let lens = PictureLens::Fisheye { aperture: PI, circle: DVec2::ONE, pixels };
    let map = PictureMap { viewer: DVec3::ZERO, position: DVec3::ZERO, lens };
    let room = room();
    let mut outcomes = Vec::new();
    for level in LEVELS {
        let name = match level {
            0 => "not divided".to_owned(),
            3 => "recipe of 2014: three fixed levels".to_owned(),
            _ => format!("fixed levels, {level}"),
        };
        let fixed = |_: [DVec3; 3], parts: &mut Parts| {
            halved(level, [DVec3::X, DVec3::Y, DVec3::Z], parts);
            0
        };
        outcomes.push(measure(name, false, &room, &map, pixels, fixed));
    }
    for max_error in BOUNDS {
        let division = Division { map, pixels, max_error, most: 1 << 14 };
        let bounded =
            |corners: [DVec3; 3], parts: &mut Parts| division.triangle(corners, &mut |part| parts.push(part)).coarse;
        outcomes.push(measure(format!("divided, at most {max_error} px"), true, &room, &map, pixels, bounded));
    }
    Divided { size, outcomes }
}

/// The triangles of the six walls of a room. The viewer is not at its centre.
fn room() -> Vec<[DVec3; 3]> {
    let at = |index: u32| 2.0 * f64::from(index) / f64::from(CELLS) - 1.0;
    let mut triangles = Vec::new();
    for face in Face::ALL {
        let corner = |x: u32, y: u32| face.rotation() * DVec3::new(at(x), at(y), -1.0) - DVec3::new(0.2, -0.3, 0.1);
        for (x, y) in (0..CELLS).flat_map(|y| (0..CELLS).map(move |x| (x, y))) {
            let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}

/// Splits a triangle into four at the midpoints of its edges, recursively `level` times.
fn halved(level: u32, [a, b, c]: [Weights; 3], parts: &mut Parts) {
    if level == 0 {
        parts.push([a, b, c]);
        return;
    }
    let [ab, bc, ca] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
    for part in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
        halved(level - 1, part, parts);
    }
}

fn measure(
    name: String,
    bounded: bool,
    room: &[[DVec3; 3]],
    map: &PictureMap,
    pixels: DVec2,
    divide: impl Fn([DVec3; 3], &mut Parts) -> usize,
) -> Outcome {
    let (mut all, mut coarse, mut errors) = (0, 0, Vec::new());
    let mut parts = Vec::new();
    let started = Instant::now();
    for corners in room {
        divide(*corners, &mut parts);
        std::hint::black_box(&parts);
        parts.clear();
    }
    let microseconds = started.elapsed().as_secs_f64() * 1e6 / room.len() as f64;
    for corners in room {
        parts.clear();
        coarse += divide(*corners, &mut parts);
        all += parts.len();
        let at = |weights: Weights| corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
        errors.extend(parts.iter().flat_map(|part| errors_of(map, part.map(at), pixels)));
    }
    let errors = sorted(errors.into_iter());
    Outcome {
        name,
        bounded,
        parts: all as f64 / room.len() as f64,
        coarse,
        greatest: errors.last().copied().unwrap_or(f64::NAN),
        most: quantile(&errors, 0.999),
        microseconds,
    }
}

/// Distances in pixels between drawn and exact positions of points of a triangle, for points within
/// the picture.
fn errors_of(map: &PictureMap, corners: [DVec3; 3], pixels: DVec2) -> Vec<f64> {
    let drawn: Vec<(DVec2, f64)> = corners
        .iter()
        .filter_map(|corner| match map.place(*corner) {
            Place::At(at) => Some((at, corner.length())),
            Place::Beyond(_) => None,
        })
        .collect();
    let &[a, b, c] = drawn.as_slice() else { return Vec::new() };
    let places = (0..=PLACES).flat_map(|i| (0..=PLACES - i).map(move |j| (i, j)));
    let error = |(i, j): (u32, u32)| {
        let (u, v) = (f64::from(i) / f64::from(PLACES), f64::from(j) / f64::from(PLACES));
        let weights = [u, v, 1.0 - u - v];
        let exact = map.shown(corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2])?;
        // Interpolation as in rasterisers; w is the distance.
        let w: f64 = [a.1, b.1, c.1].iter().zip(weights).map(|(w, weight)| w * weight).sum();
        let at = (a.0 * a.1 * weights[0] + b.0 * b.1 * weights[1] + c.0 * c.1 * weights[2]) / w;
        Some(((at - exact) * 0.5 * pixels).length())
    };
    places.filter_map(error).collect()
}

/// The results as a table.
pub fn table(divided: &Divided) -> String {
    let mut text = format!("triangles of a room, divided for a fisheye of 180°, {0} × {0}\n", divided.size);
    // Writing into a string cannot fail.
    let _ = writeln!(text, "  {:58}{:>10}{:>8}{:>11}{:>11}{:>9}", "", "triangles", "coarse", "max px", "99.9 %", "µs");
    for outcome in &divided.outcomes {
        let Outcome { name, parts, coarse, greatest, most, microseconds, .. } = outcome;
        let _ = writeln!(text, "  {name:58}{parts:10.1}{coarse:8}{greatest:11.3}{most:11.3}{microseconds:9.1}");
    }
    text.push('\n');
    text
}

/// The results as JSON.
pub fn as_json(divided: &Divided) -> Value {
    let outcomes: Vec<Value> = divided
        .outcomes
        .iter()
        .map(|outcome| {
            json!({
                "name": outcome.name,
                "triangles": outcome.parts,
                "coarse": outcome.coarse,
                "max_error_px": outcome.greatest,
                "error_999_px": outcome.most,
                "microseconds": outcome.microseconds,
            })
        })
        .collect();
    json!({ "size": divided.size, "ways": outcomes })
}

/// An SVG plot of number of triangles against greatest error, both logarithmic.
pub fn plot(divided: &Divided) -> String {
    let [left, top, right, bottom] = [80.0, 50.0, 620.0, 440.0];
    let x = |parts: f64| left + (right - left) * (parts.max(0.5) / 0.5).ln() / 8192f64.ln();
    let y = |error: f64| bottom - (bottom - top) * (error.max(0.05) / 0.05).ln() / 20_000f64.ln();
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 760 500\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"760\" height=\"500\" fill=\"white\"/>\n\
         <text x=\"{left}\" y=\"24\" font-size=\"16\">Fisheye of 180°, {0} × {0}: triangles against greatest error</text>\n",
        divided.size
    );
    // Writing into a string cannot fail.
    for error in [0.1, 1.0, 10.0, 100.0] {
        let (at, end) = (y(error), left - 6.0);
        let _ = writeln!(
            svg,
            "<path d=\"M{left} {at:.1}H{right}\" stroke=\"#ddd\"/><text x=\"{end}\" y=\"{at:.1}\" text-anchor=\"end\">{error}</text>"
        );
    }
    for parts in [1.0, 10.0, 100.0, 1000.0] {
        let (at, under) = (x(parts), bottom + 18.0);
        let _ = writeln!(
            svg,
            "<path d=\"M{at:.1} {top}V{bottom}\" stroke=\"#ddd\"/><text x=\"{at:.1}\" y=\"{under}\" text-anchor=\"middle\">{parts}</text>"
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"480\" text-anchor=\"middle\">triangles drawn for each of the scene's</text>\n\
         <text transform=\"translate(20 {}) rotate(-90)\" text-anchor=\"middle\">greatest error, pixels</text>",
        0.5 * (left + right),
        0.5 * (top + bottom)
    );
    // Labels are on the side of a point without a line.
    for (bounded, color, anchor, aside, below) in
        [(false, "#36a", "start", 8.0, -6.0), (true, "#d30", "end", -8.0, 14.0)]
    {
        let points: Vec<&Outcome> = divided.outcomes.iter().filter(|outcome| outcome.bounded == bounded).collect();
        let line: Vec<String> =
            points.iter().map(|outcome| format!("{:.1} {:.1}", x(outcome.parts), y(outcome.greatest))).collect();
        let _ = writeln!(svg, "<path d=\"M{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>", line.join("L"));
        for outcome in points {
            let (at_x, at_y) = (x(outcome.parts), y(outcome.greatest));
            let _ = writeln!(
                svg,
                "<circle cx=\"{at_x:.1}\" cy=\"{at_y:.1}\" r=\"4.5\" fill=\"{color}\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" fill=\"{color}\" text-anchor=\"{anchor}\">{}</text>",
                at_x + aside,
                at_y + below,
                outcome.name
            );
        }
    }
    svg.push_str("</svg>\n");
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Division by a bound keeps the bound, and has a smaller error than three fixed levels with
    /// fewer triangles.
    #[test]
    fn bounds_are_kept_and_beat_fixed_levels() {
        let divided = run(true);
        let recipe = divided.outcomes.iter().find(|outcome| outcome.name.contains("2014")).expect("measured");
        assert!(recipe.parts == 64.0 && recipe.greatest > 0.5, "{} px", recipe.greatest);
        let bounded: Vec<_> = divided.outcomes.iter().filter(|outcome| outcome.bounded).collect();
        for (outcome, bound) in bounded.iter().zip(BOUNDS) {
            assert!(outcome.greatest <= bound && outcome.coarse == 0, "{}: {} px", outcome.name, outcome.greatest);
        }
        assert!(
            bounded.iter().any(|outcome| outcome.greatest < recipe.greatest && outcome.parts < recipe.parts),
            "{} px with 64",
            recipe.greatest
        );
        assert!(divided.outcomes[0].greatest > 50.0, "what is not divided is far off");
    }
}
