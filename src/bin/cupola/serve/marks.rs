//! Marks from the page: lines of the file that `cupola calibrate` reads.

use crate::calibrate;
use cupola::calibrate::Part;
use cupola::rig::Rig;
use glam::DVec2;
use serde_json::{Value, json};
use std::path::PathBuf;

/// A mark.
#[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NewMark {
    /// Name of the output.
    pub output: String,
    /// The place in its picture, pixels from the top left.
    pub x: f64,
    /// The same for y.
    pub y: f64,
    /// Azimuth in degrees, 0 is the front, 90 right.
    pub azimuth: f64,
    /// Elevation in degrees above the horizon.
    pub elevation: f64,
}

/// All marks, as the text of their file.
pub struct Marks {
    file: Option<PathBuf>,
    text: String,
}

/// First line of a new file.
const HEADER: &str = "output,x,y,azimuth,elevation\n";

impl Marks {
    /// Opens the marks of a file, which need not exist yet.
    ///
    /// # Errors
    /// Description of the mistakes in the file.
    pub fn open(file: Option<PathBuf>, rig: &Rig) -> Result<Self, String> {
        let text = match file.as_deref().filter(|file| file.exists()) {
            Some(file) => {
                calibrate::marks::read(file, rig).map_err(|failure| failure.message)?;
                let text = std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
                if text.contains("polar") {
                    return Err(format!(
                        "{}: has angles of the dome (polar, around); the page makes marks with azimuth and elevation",
                        file.display()
                    ));
                }
                text
            }
            None => HEADER.to_owned(),
        };
        Ok(Self { file, text })
    }

    /// Adds a mark, whose place is one of a picture of the output's size in `shown`. The file has
    /// places in the size that `cupola calibrate` assumes.
    ///
    /// # Errors
    /// Reason why the mark is invalid, or why the file cannot be written; nothing has changed then.
    pub fn add(&mut self, mark: &NewMark, rig: &Rig, shown: &[(u32, u32)]) -> Result<(), String> {
        let mut text = self.text.clone();
        if !text.ends_with('\n') {
            text.push('\n');
        }
        let NewMark { output, x, y, azimuth, elevation } = mark;
        let index = rig.outputs.iter().position(|own| own.name == *output);
        let factor = index.map_or(DVec2::ONE, |index| factor(rig, index, shown));
        let [x, y] = (factor * DVec2::new(*x, *y)).to_array();
        text += &format!("{output},{x},{y},{azimuth},{elevation}\n");
        calibrate::marks::parse(&text, rig).map_err(|(_, _, why)| why)?;
        self.replace(text)
    }

    /// Removes the mark in a line, from 1.
    ///
    /// # Errors
    /// There is no mark, or the file cannot be written.
    pub fn remove(&mut self, line: usize, rig: &Rig) -> Result<(), String> {
        if !self.lines(rig).iter().any(|mark| mark.number == line) {
            return Err(format!("there is no mark in line {line}"));
        }
        let kept = self.text.split_inclusive('\n').zip(1..).filter(|(_, number)| *number != line);
        self.replace(kept.map(|(text, _)| text).collect())
    }

    fn replace(&mut self, text: String) -> Result<(), String> {
        if let Some(file) = &self.file {
            crate::tune::replace(file, &text).map_err(|error| format!("{}: {error}", file.display()))?;
        }
        self.text = text;
        Ok(())
    }

    /// Parsed lines; empty if they do not fit the rig.
    fn lines(&self, rig: &Rig) -> Vec<calibrate::marks::Line> {
        calibrate::marks::parse(&self.text, rig).unwrap_or_default()
    }

    /// All marks, and the name of the file, as JSON; places are those of pictures of the sizes
    /// `shown`.
    pub fn state(&self, rig: &Rig, shown: &[(u32, u32)]) -> Value {
        let marks = self.lines(rig).into_iter().filter_map(|line| {
            let index = line.mark?.output;
            let output = rig.outputs[index].name.as_str();
            let direction = line.direction;
            let azimuth = direction.x.atan2(-direction.z).to_degrees();
            let elevation = direction.y.clamp(-1.0, 1.0).asin().to_degrees();
            // Hundredths of a pixel, so that a place that was scaled is what was set.
            let [x, y] = (line.pixel / factor(rig, index, shown) * 100.0).round().to_array().map(|x| x / 100.0);
            Some(json!({
                "line": line.number, "output": output, "x": x, "y": y, "azimuth": azimuth, "elevation": elevation,
            }))
        });
        json!({ "file": self.file.as_ref().map(|file| file.display().to_string()), "list": marks.collect::<Vec<_>>() })
    }

    /// Solves the outputs that have marks. Returns changes of the rig `text`, and the results in
    /// words.
    ///
    /// # Errors
    /// Reason why nothing can be solved.
    pub fn solve(&self, rig: &Rig, text: &str, parts: &[String]) -> Result<(Vec<String>, Vec<String>), String> {
        let mut free = vec![Part::Pose];
        for word in parts {
            let part = calibrate::part(word)?;
            if !free.contains(&part) {
                free.push(part);
            }
        }
        let lines = self.lines(rig);
        let (mut changes, mut words) = (Vec::new(), Vec::new());
        for (output, described) in rig.outputs.iter().enumerate() {
            let own = lines.iter().filter_map(|line| Some((line.mark?, line.number)));
            let (own, numbers): (Vec<_>, Vec<_>) = own.filter(|(mark, _)| mark.output == output).unzip();
            if own.is_empty() {
                continue;
            }
            let size = crate::map::native_size(rig, output);
            let solved = cupola::calibrate::marks::solve(rig, output, size, &own, &free);
            let solved = solved.map_err(|error| error.message)?;
            changes.extend(calibrate::changes(text, &described.name, &solved.optics, &free)?);
            words.push(format!("{}: {}", described.name, calibrate::summary(&solved.quality)));
            words.extend(calibrate::left_out(&numbers, &solved.quality).map(|(line, distance)| {
                format!("  line {line} of the marks: left out, {}", calibrate::away(distance))
            }));
        }
        if words.is_empty() { Err("there are no marks yet".to_owned()) } else { Ok((changes, words)) }
    }
}

/// Pixels of an output's native size for a pixel of its size in `shown`.
fn factor(rig: &Rig, output: usize, shown: &[(u32, u32)]) -> DVec2 {
    let native = crate::map::native_size(rig, output);
    let [native, shown] = [native, shown.get(output).copied().unwrap_or(native)]
        .map(|(width, height)| DVec2::new(f64::from(width.max(1)), f64::from(height.max(1))));
    native / shown
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::launch::loader::Scratch;
    use crate::tune;
    use cupola::warp::WarpMap;
    use std::path::Path;

    fn rig(yaw: f64, size: &str) -> (String, Rig) {
        let text = format!(
            "[dome]\ntilt = 20\n[[output]]\nname = \"a\"\nkind = \"projector\"\n{size}position = [0, 0, 1]\n\
             pitch = 30\nyaw = {yaw}\nfov = [80, 55]\nflip = \"horizontal\"\n"
        );
        let rig = cupola::rig::parse(&text, "rig.toml", Path::new("")).expect("a rig");
        (text, rig)
    }

    #[test]
    fn marks_lead_to_the_projector_and_to_a_file() {
        lead_to_the_projector("size = [800, 500]\n", (800, 500));
        // The size is that of the program's window.
        lead_to_the_projector("", (640, 400));
    }

    /// Marks of a projector whose picture is shown in the size `shown`.
    fn lead_to_the_projector(size: &str, shown: (u32, u32)) {
        let scratch = Scratch::new().expect("a folder");
        let file = scratch.path().join("marks.csv");
        let ((_, exact), (text, rough)) = (rig(3.0, size), rig(0.0, size));
        std::fs::write(&file, "output,x,y,polar,around\na,1,1,10,10\n").expect("written");
        assert!(Marks::open(Some(file.clone()), &rough).is_err(), "other angles");
        std::fs::remove_file(&file).expect("removed");
        let mut marks = Marks::open(Some(file.clone()), &rough).expect("new");
        assert!(marks.solve(&rough, &text, &[]).is_err());
        let map = WarpMap::new(&exact, 0, shown, None).expect("a map");
        for place in 0..12 {
            let pixel = DVec2::new(100.5 + 150.0 * f64::from(place % 4), 60.5 + 120.0 * f64::from(place / 4));
            let direction = map.hit(pixel).expect("lit").normalize();
            let azimuth = direction.x.atan2(-direction.z).to_degrees();
            let mark = NewMark {
                output: "a".into(),
                x: pixel.x,
                y: pixel.y,
                azimuth,
                elevation: direction.y.asin().to_degrees(),
            };
            marks.add(&mark, &rough, &[shown]).expect("a mark");
        }
        let wrong = NewMark { output: "b".into(), x: 1.0, y: 1.0, azimuth: 0.0, elevation: 0.0 };
        assert!(marks.add(&wrong, &rough, &[shown]).expect_err("no output").contains("no output \"b\""));
        let (changes, words) = marks.solve(&rough, &text, &["fov".into()]).expect("solved");
        assert!(words[0].starts_with("a: 12 of 12 marks"), "{words:?}");
        let solved = tune::changed(&text, &changes).expect("keys");
        let solved = cupola::rig::parse(&solved, "rig.toml", Path::new("")).expect("valid");
        let found = WarpMap::new(&solved, 0, shown, None).expect("a map");
        let place = DVec2::new(321.0, 123.0);
        assert!(found.pixel(map.hit(place).expect("lit")).expect("there").distance(place) < 1e-3);
        let mut again = Marks::open(Some(file), &rough).expect("read again");
        assert_eq!(again.state(&rough, &[shown])["list"].as_array().map(Vec::len), Some(12));
        assert_eq!(again.state(&rough, &[shown])["list"][0]["x"].as_f64(), Some(100.5));
        again.remove(5, &rough).expect("there");
        assert!(again.remove(50, &rough).is_err());
        assert_eq!(again.state(&rough, &[shown])["list"].as_array().map(Vec::len), Some(11));
    }
}
