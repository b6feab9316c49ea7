//! A plot of error against noise.

use super::trials::Series;
use std::fmt::Write;

/// Width and height of the plot in pixels.
const SIZE: (f64, f64) = (900.0, 580.0);
/// Left, top, right and bottom of the area with the points.
const AREA: [f64; 4] = [80.0, 50.0, 860.0, 440.0];
/// Range of both axes, pixels.
const RANGE: (f64, f64) = (0.001, 10.0);
const COLORS: [&str; 3] = ["#36a", "#d30", "#292"];

/// Position of a value between the ends of [`RANGE`], 0…1.
fn part(value: f64) -> f64 {
    (value.clamp(RANGE.0, RANGE.1) / RANGE.0).ln() / (RANGE.1 / RANGE.0).ln()
}

fn x(noise: f64) -> f64 {
    AREA[0] + (AREA[2] - AREA[0]) * part(noise)
}

fn y(error: f64) -> f64 {
    AREA[3] - (AREA[3] - AREA[1]) * part(error)
}

/// An SVG plot, both axes logarithmic: results as points, the limits as lines.
pub fn errors(series: &[Series]) -> String {
    let [left, top, right, bottom] = AREA;
    let (width, height) = SIZE;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n\
         <text x=\"{left}\" y=\"24\" font-size=\"16\">cupola calibrate, planetarium-6: error against noise</text>\n\
         <text x=\"{}\" y=\"{}\" text-anchor=\"middle\">noise: standard deviation of each coordinate, pixels</text>\n\
         <text transform=\"translate(20 {}) rotate(-90)\" text-anchor=\"middle\">error, rms over the pictures, pixels</text>\n",
        0.5 * (left + right),
        bottom + 40.0,
        0.5 * (top + bottom)
    );
    for value in [0.001, 0.01, 0.1, 1.0, 10.0] {
        // Writing into a string cannot fail.
        let _ = writeln!(
            svg,
            "<path d=\"M{left} {0:.1}H{right}M{1:.1} {top}V{bottom}\" stroke=\"#ddd\" fill=\"none\"/>\
             <text x=\"{2}\" y=\"{3:.1}\" text-anchor=\"end\">{value}</text>\
             <text x=\"{1:.1}\" y=\"{4}\" text-anchor=\"middle\">{value}</text>",
            y(value),
            x(value),
            left - 6.0,
            y(value) + 4.0,
            bottom + 18.0
        );
    }
    for (index, (series, color)) in series.iter().zip(COLORS).enumerate() {
        let line: Vec<String> =
            series.points.iter().map(|point| format!("{:.1} {:.1}", x(point.noise), y(point.limit))).collect();
        let _ = writeln!(svg, "<path d=\"M{}\" fill=\"none\" stroke=\"{color}\"/>", line.join("L"));
        for point in &series.points {
            let (x, y) = (x(point.noise), y(point.error));
            let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{color}\"/>");
        }
        let row = bottom + 66.0 + 18.0 * index as f64;
        let name = series.name.replace('&', "&amp;").replace('<', "&lt;");
        let _ = writeln!(svg, "<text x=\"{left}\" y=\"{row}\" fill=\"{color}\">● {name}</text>");
    }
    let row = bottom + 66.0 + 18.0 * series.len() as f64;
    let _ =
        writeln!(svg, "<text x=\"{left}\" y=\"{row}\">Lines: the least error that is possible (Cramér, Rao)</text>");
    svg.push_str("</svg>\n");
    svg
}
