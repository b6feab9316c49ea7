//! Files of marks: comma-separated values.

use crate::failure::Failure;
use crate::map::native_size;
use cupola::calibrate::Mark;
use cupola::rig::Rig;
use glam::{DMat3, DVec2, DVec3};
use std::path::Path;

/// A mark with its line in the file.
#[derive(Debug)]
pub struct Line {
    /// Number of the line, from 1.
    pub number: usize,
    /// The mark; `None` for a place in the photographs.
    pub mark: Option<Mark>,
    /// The place, pixels from the top left.
    pub pixel: DVec2,
    /// The direction from the dome's centre, dome axes, unit length.
    pub direction: DVec3,
}

/// Name of the photographs.
const PHOTO: &str = "photo";
/// Largest photograph, pixels.
const LARGEST_PHOTO: u32 = 65535;

/// Longest file, bytes.
const LONGEST: u64 = 64 << 20;
const HORIZON: [&str; 5] = ["output", "x", "y", "azimuth", "elevation"];
const DOME: [&str; 5] = ["output", "x", "y", "polar", "around"];

/// Meaning of the last two columns.
#[derive(Clone, Copy, PartialEq)]
enum Angles {
    /// Azimuth and elevation.
    Horizon,
    /// Angle from the dome's pole, and around it.
    Dome,
}

/// Reads the marks for the outputs of a rig.
///
/// # Errors
/// The first mistake, with file, line and column.
pub fn read(file: &Path, rig: &Rig) -> Result<Vec<Line>, Failure> {
    let name = file.display().to_string();
    let unreadable = |why: String| Failure::usage(format!("{name}: {why}"));
    let length = std::fs::metadata(file).map_err(|error| unreadable(error.to_string()))?.len();
    if length > LONGEST {
        return Err(unreadable(format!("is longer than {LONGEST} bytes, the limit for files of marks")));
    }
    let text = std::fs::read_to_string(file).map_err(|error| unreadable(error.to_string()))?;
    let lines =
        parse(&text, rig).map_err(|(line, column, why)| Failure::usage(format!("{name}:{line}:{column}: {why}")))?;
    if lines.is_empty() {
        return Err(unreadable(format!("has no marks; expected lines {}", HORIZON.join(","))));
    }
    Ok(lines)
}

/// A mistake: line, column, and message.
pub type Mistake = (usize, usize, String);

/// Reads the text of a file of marks.
///
/// # Errors
/// The first mistake.
pub fn parse(text: &str, rig: &Rig) -> Result<Vec<Line>, Mistake> {
    let mut angles = Angles::Horizon;
    let mut lines = Vec::new();
    let mut first = true;
    for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        if line.trim().is_empty() || line.trim_start().starts_with('#') {
            continue;
        }
        let fields = fields(line);
        let words: Vec<&str> = fields.iter().map(|(_, field)| *field).collect();
        let is_header = std::mem::take(&mut first) && words[0].eq_ignore_ascii_case("output");
        if is_header {
            angles = match &words[..] {
                words if words == HORIZON => Angles::Horizon,
                words if words == DOME => Angles::Dome,
                _ => {
                    let expected = format!("expected {} or {}", HORIZON.join(","), DOME.join(","));
                    return Err((number, 1, format!("the columns are not known; {expected}")));
                }
            };
            continue;
        }
        let (output, pixel, direction) = mark(&fields, angles, rig).map_err(|(column, why)| (number, column, why))?;
        lines.push(Line { number, mark: output.map(|output| Mark { output, pixel, direction }), pixel, direction });
    }
    Ok(lines)
}

/// Fields of a line with their columns, from 1.
fn fields(line: &str) -> Vec<(usize, &str)> {
    let mut column = 1;
    let mut fields = Vec::new();
    for field in line.split(',') {
        let blank = field.chars().take_while(|letter| letter.is_whitespace()).count();
        fields.push((column + blank, field.trim().trim_matches('"')));
        column += field.chars().count() + 1;
    }
    fields
}

/// Number of the output (`None` for the photographs), place in it, and direction.
type Place = (Option<usize>, DVec2, DVec3);

fn mark(fields: &[(usize, &str)], angles: Angles, rig: &Rig) -> Result<Place, (usize, String)> {
    let names = if angles == Angles::Horizon { HORIZON } else { DOME };
    let [(column, output), x, y, first, second] = fields else {
        let column = fields.last().map_or(1, |field| field.0);
        return Err((column, format!("{} values; expected five: {}", fields.len(), names.join(","))));
    };
    let index = rig.outputs.iter().position(|own| own.name == *output);
    if index.is_none() && *output != PHOTO {
        let all: Vec<&str> = rig.outputs.iter().map(|output| output.name.as_str()).collect();
        return Err((*column, format!("there is no output {output:?}; the rig has {}", all.join(", "))));
    }
    let (width, height) = index.map_or((LARGEST_PHOTO, LARGEST_PHOTO), |index| native_size(rig, index));
    let pixels = |field, end: u32, what| number(field, 0.0, f64::from(end), what);
    let pixel = DVec2::new(pixels(x, width, "x, pixels from the left")?, pixels(y, height, "y, pixels from the top")?);
    let direction = match angles {
        Angles::Horizon => towards(
            number(first, -360.0, 360.0, "azimuth, degrees: 0 = front, 90 = right")?,
            number(second, -90.0, 90.0, "elevation, degrees above the horizon")?,
        ),
        Angles::Dome => {
            let polar = number(first, 0.0, 180.0, "polar, degrees from the dome's pole")?;
            let around = number(second, -360.0, 360.0, "around, degrees around the pole: 0 = front, 90 = right")?;
            DMat3::from_rotation_x(-rig.dome.tilt) * towards(around, 90.0 - polar)
        }
    };
    Ok((index, pixel, direction))
}

fn number((column, text): &(usize, &str), least: f64, most: f64, what: &str) -> Result<f64, (usize, String)> {
    match text.parse::<f64>() {
        Ok(number) if (least..=most).contains(&number) => Ok(number),
        Ok(number) => Err((*column, format!("{number} is out of range; expected {what}, {least} to {most}"))),
        Err(_) => Err((*column, format!("{text:?} is no number; expected {what}"))),
    }
}

/// Unit vector of an azimuth and an elevation in degrees.
fn towards(azimuth: f64, elevation: f64) -> DVec3 {
    let ((sine, cosine), (up, level)) = (azimuth.to_radians().sin_cos(), elevation.to_radians().sin_cos());
    DVec3::new(level * sine, up, -level * cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Vec<Line>, Mistake> {
        parse(text, &cupola::rig::load("planetarium-6").expect("a preset"))
    }

    #[test]
    fn both_kinds_of_angles_are_read() {
        let lines = parsed("# by hand\n\nfront, 10.5, 20,90,0\r\n").expect("right");
        assert_eq!((lines.len(), lines[0].number, lines[0].mark.map(|mark| mark.output)), (1, 3, Some(0)));
        assert!(lines[0].direction.distance(DVec3::X) < 1e-15 && lines[0].pixel == DVec2::new(10.5, 20.0));
        let lines = parsed("output,x,y,polar,around\nzenith,0,0,0,0\nzenith,0,0,90,0\n").expect("right");
        // The pole leans to the front by 25°.
        let tilt = 25f64.to_radians();
        assert!(lines[0].direction.distance(DVec3::new(0.0, tilt.cos(), -tilt.sin())) < 1e-15);
        assert!(lines[1].direction.distance(DVec3::new(0.0, -tilt.sin(), -tilt.cos())) < 1e-15);
    }

    #[test]
    fn mistakes_have_line_and_column() {
        for (text, line, column, word) in [
            ("front,1,2,3,4\n fronnt,1,2,3,4\n", 2, 2, "no output \"fronnt\""),
            ("front,1,2,3\n", 1, 11, "4 values"),
            ("front, 1,2a,3,4\n", 1, 10, "\"2a\" is no number"),
            ("front,1,2,3,94\n", 1, 13, "94 is out of range"),
            ("front,1921,2,3,4\n", 1, 7, "0 to 1920"),
            ("front,nan,2,3,4\n", 1, 7, "out of range"),
            ("output,x,y,a,b\n", 1, 1, "columns are not known"),
        ] {
            let (at, place, why) = parsed(text).expect_err(text);
            assert!((at, place) == (line, column) && why.contains(word), "{text}: {at}:{place}: {why}");
        }
    }
}
