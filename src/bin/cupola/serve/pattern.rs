//! Test patterns in place of the program's picture.
//!
//! A rig can raise black to a picture, pixel by pixel, and mask the program's picture. A pattern is
//! a picture of black with a black mask: every graphics API and every kind of output shows it while
//! the program goes on.

use crate::canvas::Canvas;
use crate::pattern::draw::{Part, Pattern};
use cupola::rig::{Method, Output, Rig};
use glam::DVec2;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Distance from the middle of a crosshair within which pixels are white.
const NEAR: i64 = 20;

/// Choice of a pattern.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// Parts, as for `cupola pattern --parts`; none: the program's picture.
    #[serde(default)]
    pub parts: Vec<String>,
    /// Distance between lines, degrees.
    #[serde(default)]
    pub step: Option<f64>,
    /// Name of the only output that is not black.
    #[serde(default)]
    pub only: Option<String>,
    /// Directions of crosses: azimuth and elevation in degrees.
    #[serde(default)]
    pub at: Vec<[f64; 2]>,
    /// Position of a crosshair.
    #[serde(default)]
    pub cursor: Option<Cursor>,
}

/// A place of an output's picture.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cursor {
    /// Name of the output.
    pub output: String,
    /// Pixels from the left.
    pub x: f64,
    /// Pixels from the top.
    pub y: f64,
}

impl Choice {
    /// True if the program's picture is shown.
    pub fn is_none(&self) -> bool {
        self.parts.is_empty() && self.at.is_empty() && self.cursor.is_none()
    }
}

/// Draws the pattern with this `number` for outputs of these sizes into `folder`. Returns changes
/// of the rig that show it.
///
/// # Errors
/// Description of the mistake in the choice.
pub fn changes(
    rig: &Rig,
    sizes: &[(u32, u32)],
    choice: &Choice,
    folder: &Path,
    number: u64,
) -> Result<Vec<String>, String> {
    let part = |name: &String| {
        <Part as clap::ValueEnum>::from_str(name, false).map_err(|_| format!("there is no pattern {name:?}"))
    };
    let parts: Vec<Part> = choice.parts.iter().map(part).collect::<Result<_, _>>()?;
    let step = choice.step.unwrap_or(10.0);
    if !(0.1..=90.0).contains(&step)
        || choice.at.len() > 100
        || choice.at.iter().flatten().any(|angle| !angle.is_finite())
    {
        return Err("a pattern has lines 0.1 to 90 degrees apart, and at most 100 crosses".to_owned());
    }
    let is_named = |name: &String| rig.outputs.iter().any(|output| output.name == *name);
    let cursor = choice.cursor.as_ref();
    let names = [choice.only.as_ref(), cursor.map(|cursor| &cursor.output)];
    if let Some(name) = names.into_iter().flatten().find(|name| !is_named(name)) {
        return Err(format!("there is no output {name:?}"));
    }
    if cursor.is_some_and(|cursor| !cursor.x.is_finite() || !cursor.y.is_finite()) {
        return Err("the position of the crosshair is not finite".to_owned());
    }
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    std::fs::create_dir_all(folder).map_err(failed)?;
    // Black is raised in the picture before it is mirrored.
    let upright = rig.upright();
    let pattern = Pattern::new(&upright, sizes, &parts, step, &choice.at).map_err(|failure| failure.message)?;
    let dark = folder.join("dark.png");
    write(&dark, &Canvas::new(1, 1, [0.0; 3]))?;
    let file = |output: &Output| folder.join(format!("{}-{number}.png", output.name));
    let draw = |(index, output): (usize, &Output)| {
        let is_black = choice.only.as_ref().is_some_and(|only| *only != output.name);
        let mut picture = match is_black {
            true => Canvas::new(sizes[index].0 as usize, sizes[index].1 as usize, [0.0; 3]),
            false => pattern.draw(index),
        };
        if let Some(cursor) = cursor.filter(|cursor| cursor.output == output.name) {
            let place = output.flip.pixel(DVec2::new(cursor.x, cursor.y), sizes[index]);
            crosshair(&mut picture, place);
        }
        write(&file(output), &picture)
    };
    let next = AtomicUsize::new(0);
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(rig.outputs.len());
    std::thread::scope(|scope| {
        let work = || {
            let mut numbers = std::iter::from_fn(|| Some(next.fetch_add(1, Ordering::Relaxed)));
            numbers.by_ref().map_while(|index| rig.outputs.get(index).map(|output| (index, output))).try_for_each(draw)
        };
        let threads: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        let failed = |_| Err("drawing the pattern failed".to_owned());
        threads.into_iter().try_for_each(|thread| thread.join().unwrap_or_else(failed))
    })?;
    Ok(rig_changes(rig, &dark, file))
}

/// Changes of the rig that show the picture `file` of each output instead of the program's: they
/// raise the black level to it, and `dark` masks everything else.
fn rig_changes(rig: &Rig, dark: &Path, file: impl Fn(&Output) -> PathBuf) -> Vec<String> {
    let mut changes = Vec::new();
    for output in &rig.outputs {
        let file = file(output);
        let key = |rest: &str| format!("output.{}.{rest}", output.name);
        changes.push(key(&format!("mask={{ image = {:?} }}", dark.display().to_string())));
        changes.push(key(&format!("black={{ image = {:?} }}", file.display().to_string())));
        if output.blend.black_level > 0.0 {
            changes.push(key("blend.black_level=0"));
        }
        if output.blend.contrast.is_some() {
            changes.push(key("blend.contrast=1e9"));
        }
        if matches!(output.method, Method::Vertex | Method::Primitive { .. }) {
            changes.push(key("method=\"fragment\""));
        }
    }
    changes
}

/// Draws lines through a pixel, brighter around it; the pixel is the middle.
fn crosshair(picture: &mut Canvas, place: DVec2) {
    let (column, row) = (place.x.floor() as i64, place.y.floor() as i64);
    let color = |away: i64| if away.abs() <= NEAR { [1.0, 1.0, 1.0] } else { [0.1, 0.6, 0.2] };
    (0..picture.width as i64).for_each(|x| picture.blend(x, row, color(x - column), 1.0));
    (0..picture.height as i64).for_each(|y| picture.blend(column, y, color(y - row), 1.0));
}

/// Removes the pictures of patterns before `number`. The program may still be reading the newest of
/// them.
pub fn tidy(folder: &Path, number: u64) {
    let older = |name: &str| {
        let stem = name.strip_suffix(".png")?;
        stem.rsplit_once('-')?.1.parse::<u64>().ok().filter(|found| found + 1 < number)
    };
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if older(&entry.file_name().to_string_lossy()).is_some() {
            // At the latest the file is removed with its folder.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

fn write(file: &Path, picture: &Canvas) -> Result<(), String> {
    let (width, height) = (picture.width as u32, picture.height as u32);
    image::save_buffer(file, &picture.bytes(), width, height, image::ColorType::Rgb8)
        .map_err(|error| format!("{}: {error}", file.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::launch::loader::Scratch;
    use crate::tune;

    #[test]
    fn a_pattern_is_a_valid_change_of_the_rig() {
        let scratch = Scratch::new().expect("a folder");
        let text = "[[output]]\nname = \"a\"\nkind = \"domemaster\"\nsize = [64, 64]\nblend = { black_level = 0.1 }\n\
                    [[output]]\nname = \"b\"\nkind = \"projector\"\nfov = [60, 40]\nmethod = \"primitive\"\nflip = \"both\"\n";
        let rig = cupola::rig::parse(text, "rig.toml", Path::new("")).expect("a rig");
        let choice = Choice {
            parts: vec!["horizon".into(), "border".into()],
            step: None,
            only: Some("a".into()),
            at: Vec::new(),
            cursor: None,
        };
        let folder = scratch.path().join("pattern");
        let changes = changes(&rig, &[(64, 64), (40, 30)], &choice, &folder, 1).expect("a pattern");
        let changed = tune::changed(text, &changes).expect("keys");
        let shown = cupola::rig::parse(&changed, "rig.toml", Path::new("")).expect("valid");
        assert!(shown.outputs.iter().all(|output| output.black.is_some() && output.mask.is_some()));
        // The output that was not chosen is dark, the other one is not.
        let lit =
            |name: &str| image::open(folder.join(name)).expect("a picture").into_rgb8().iter().any(|value| *value > 0);
        assert!(lit("a-1.png") && !lit("b-1.png") && !lit("dark.png"));
        let cursor = Some(Cursor { output: "b".into(), x: 30.5, y: 10.5 });
        let crossed = Choice { cursor, parts: Vec::new(), only: Some("b".into()), ..choice.clone() };
        super::changes(&rig, &[(64, 64), (40, 30)], &crossed, &folder, 1).expect("a crosshair");
        let picture = image::open(folder.join("b-1.png")).expect("a picture").into_rgb8();
        // The output is mirrored both ways afterwards.
        assert_eq!(picture.get_pixel(9, 19).0, [255; 3]);
        assert_eq!((picture.get_pixel(10, 18).0, picture.get_pixel(0, 0).0), ([0; 3], [0; 3]));
        let wrong = Choice { parts: vec!["nothing".into()], ..choice };
        assert!(super::changes(&rig, &[(64, 64), (40, 30)], &wrong, &folder, 2).is_err());
        tidy(&folder, 2);
        assert!(folder.join("a-1.png").exists());
        tidy(&folder, 3);
        assert!(!folder.join("a-1.png").exists() && folder.join("dark.png").exists());
    }
}
