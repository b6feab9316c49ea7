//! `cupola pattern`: test pictures for the outputs of a rig.

pub mod draw;

use crate::canvas::Canvas;
use crate::failure::Failure;
use crate::terminal;
use crate::window::screens::Screen;
use cupola::rig::Rig;
use draw::{Part, Pattern};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Draw test patterns for the outputs of a rig: grids of dome angles with labels, names and
/// borders, overlaps, crosses at given directions, grey and colour ramps, focus.
#[derive(clap::Args)]
#[command(after_help = "\
Each output is drawn through its exact map, without blending: where two projectors meet, lines that do not coincide show
an error of the rig or of the projectors. Azimuth 0 is the front, to the right; elevation 0 is the horizon. The angles
of `dome` are those of ramps: from the pole, and around it.")]
pub struct Arguments {
    /// Rig file or name of a preset
    #[arg(value_name = "FILE|PRESET")]
    rig: String,
    /// Parts of the pattern, drawn over each other in this order
    #[arg(long, value_name = "PART,…", value_enum, value_delimiter = ',', default_values_t = [Part::Horizon, Part::Border])]
    parts: Vec<Part>,
    /// Distance between lines of a grid, degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 10.0, value_parser = crate::decimal::number)]
    step: f64,
    /// A cross in this direction, degrees; may be given several times
    #[arg(long, value_name = "AZIMUTH,ELEVATION", allow_hyphen_values = true, value_parser = direction)]
    at: Vec<[f64; 2]>,
    /// Name of the only output that is not black
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
    /// Window size in pixels [default: from the rig, or 1920x1200]
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size)]
    size: Option<(u32, u32)>,
    /// Folder to write to: NAME.png for each output, and window.png with all of them in their
    /// places
    #[arg(short = 'o', long = "out", value_name = "DIR", required_unless_present = "show")]
    folder: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long, conflicts_with = "show")]
    json: bool,
    /// Show the patterns on the screens and monitors of the rig until a key is pressed
    #[arg(long)]
    show: bool,
}

impl Arguments {
    /// Arguments for patterns with the number and the name of each output, and its grid.
    pub fn numbered(rig: String, folder: Option<PathBuf>, show: bool) -> Self {
        let parts = vec![Part::Horizon, Part::Border];
        Self { rig, parts, step: 10.0, at: Vec::new(), only: None, size: None, folder, json: false, show }
    }
}

/// Reads `AZIMUTH,ELEVATION`.
pub fn direction(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split_once(',').and_then(|(azimuth, elevation)| {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
        Some([number(azimuth)?, number(elevation)?])
    });
    numbers.ok_or_else(|| "expected two angles in degrees, for example 45,30".to_owned())
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let rig = cupola::rig::load(&arguments.rig)?.with_all_outputs().into_owned();
    if !(0.1..=90.0).contains(&arguments.step) {
        return Err(Failure::usage(format!("--step {}: expected 0.1 to 90 degrees", arguments.step)));
    }
    let names: Vec<&str> = rig.outputs.iter().map(|output| output.name.as_str()).collect();
    if names.is_empty() {
        return Err(Failure::usage(format!("the rig {} has no outputs", rig.name)));
    }
    if let Some(name) = arguments.only.as_deref().filter(|name| !names.contains(name)) {
        return Err(Failure::usage(format!(
            "the rig {} has no output {name:?}; it has {}",
            rig.name,
            names.join(", ")
        )));
    }
    let pictures = pictures(arguments, &rig)?;
    let window = assembled(&rig, arguments.size, &pictures);
    if let Some(folder) = &arguments.folder {
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::usage(format!("the folder {} cannot be created: {error}", folder.display())))?;
        for (name, picture) in names.iter().zip(&pictures) {
            write(&folder.join(format!("{name}.png")), picture)?;
        }
        write(&folder.join("window.png"), &window)?;
        let (width, height) = (window.width, window.height);
        if arguments.json {
            let answer = json!({ "folder": folder.display().to_string(), "outputs": names, "window": [width, height] });
            println!("{answer:#}");
            return Ok(ExitCode::SUCCESS);
        }
        println!("{}: {} outputs, and window.png with {width} × {height} pixels", folder.display(), names.len());
    }
    if arguments.show {
        show(&rig, &pictures, &window)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Patterns of the outputs, in their sizes.
fn pictures(arguments: &Arguments, rig: &Rig) -> Result<Vec<Canvas>, Failure> {
    let sizes: Vec<(u32, u32)> = rig
        .sizes(window_size(rig, arguments.size))
        .into_iter()
        .map(|(width, height)| (width.max(1), height.max(1)))
        .collect();
    let bar = terminal::progress(rig.outputs.len() as u64, "outputs");
    let pattern = Pattern::new(rig, &sizes, &arguments.parts, arguments.step, &arguments.at)?;
    let picture = |(index, &(width, height)): (usize, &(u32, u32))| {
        let black = arguments.only.as_ref().is_some_and(|only| *only != rig.outputs[index].name);
        let picture = match black {
            true => Canvas::new(width as usize, height as usize, [0.0; 3]),
            false => pattern.draw(index),
        };
        bar.inc(1);
        picture
    };
    Ok(sizes.iter().enumerate().map(picture).collect())
}

fn window_size(rig: &Rig, given: Option<(u32, u32)>) -> (u32, u32) {
    given.or_else(|| rig.extent()).unwrap_or((1920, 1200))
}

/// Picture of the window with all outputs in their rectangles.
fn assembled(rig: &Rig, size: Option<(u32, u32)>, pictures: &[Canvas]) -> Canvas {
    let (width, height) = window_size(rig, size);
    let mut window = Canvas::new(width as usize, height as usize, [0.0; 3]);
    let places = rig.layout((width, height));
    let shown = rig.outputs.iter().zip(&places).zip(pictures).filter(|((output, _), _)| output.shown);
    for ((_, place), picture) in shown {
        window.paste(picture, place.x as usize, place.y as usize);
    }
    window
}

fn write(file: &Path, picture: &Canvas) -> Result<(), Failure> {
    let (width, height) = (picture.width as u32, picture.height as u32);
    image::save_buffer(file, &picture.bytes(), width, height, image::ColorType::Rgb8)
        .map_err(|error| Failure::new(format!("{} cannot be written: {error}", file.display())))
}

/// Interval at which the command looks for pressed keys.
const LOOK: Duration = Duration::from_millis(50);

/// Shows the patterns, pixel for pixel, on all screens of the rig until a key is pressed.
fn show(rig: &Rig, pictures: &[Canvas], window: &Canvas) -> Result<(), Failure> {
    for output in rig.outputs.iter().filter(|output| !Screen::is_seen(output)) {
        eprintln!("cupola: {} is not shown: it has shown = false; -o writes its picture", output.name);
    }
    let mut screens = Screen::open(rig, 0..rig.outputs.len(), None)?;
    let put = |screen: &mut Screen| {
        let picture = screen.output.map_or(window, |output| &pictures[output]);
        let rgba: Vec<u8> =
            picture.bytes().chunks_exact(3).flat_map(|pixel| [pixel[0], pixel[1], pixel[2], u8::MAX]).collect();
        screen.show((picture.width as u32, picture.height as u32), &rgba)
    };
    for screen in &mut screens {
        put(screen)?;
        screen.take_keyboard()?;
    }
    eprintln!("cupola: press any key, or click, to close the patterns");
    loop {
        for screen in &mut screens {
            let heard = screen.heard()?;
            if heard.is_pressed {
                return Ok(());
            }
            if heard.is_uncovered {
                put(screen)?;
            }
        }
        std::thread::sleep(LOOK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_two_numbers() {
        assert_eq!(direction("-45, 30.5"), Ok([-45.0, 30.5]));
        for wrong in ["", "45", "45,", "a,b", "1,2,3", "nan,0"] {
            assert!(direction(wrong).is_err(), "{wrong}");
        }
    }
}
