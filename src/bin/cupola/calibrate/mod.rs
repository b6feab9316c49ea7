//! `cupola calibrate`: places, aims and lenses of projectors from marks on the dome or
//! photographs of it.

mod compared;
mod length;
mod light;
pub mod marks;
mod patterns;
mod photographs;
mod report;
mod shooting;
mod written;

pub use report::{away, left_out, summary};
pub use written::changes;

use crate::convert;
use crate::failure::Failure;
use crate::map::native_size;
use crate::terminal;
use cupola::calibrate::{Mark, Part, Solved};
use cupola::rig::{self, Rig};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Find the real positions and lenses of projectors: from places of their pictures whose directions
/// in the dome are known, or from photographs of patterns.
#[derive(clap::Args)]
#[command(after_help = "\
The file of marks has a line for each: the output's name, the place in its picture in pixels from the top left
(the middle of the first pixel is 0.5, 0.5), and the azimuth and elevation of the point of the dome that it
lights, degrees, as seen from the dome's centre. With the first line `output,x,y,polar,around` the angles are
those of the dome: from its pole, and around it. The name `photo` means a place in the photographs. Wrong marks
are found and left out, up to about a third of an output's. Outputs without observations stay as they are.
See docs/calibrating.md.")]
pub struct Arguments {
    /// Rig file or name of a preset, roughly right
    #[arg(value_name = "FILE|PRESET")]
    rig: String,
    /// Write the patterns to photograph to this folder: as many PNG files as photographs, each as
    /// large as the window
    #[arg(long, value_name = "DIR", conflicts_with_all = ["marks", "photos", "out", "solve"])]
    patterns: Option<PathBuf>,
    /// Show the patterns on the projectors, and run this command for each of them: it makes a
    /// photograph, {} is its file without ending. With --out the rig is solved then
    #[arg(long, value_name = "COMMAND", requires = "photos", conflicts_with = "patterns")]
    camera: Option<String>,
    /// Time between a pattern and its photograph in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.5, value_parser = crate::decimal::number, requires = "camera")]
    pause: f64,
    /// X screen of the rig's window with --camera, for example :0.1 [default: $DISPLAY]
    #[arg(long, value_name = "NAME", requires = "camera")]
    display: Option<String>,
    /// Folder with the photographs of these patterns as PNG or JPEG files, named in their order
    #[arg(long, value_name = "DIR", required_unless_present_any = ["marks", "patterns"])]
    photos: Option<PathBuf>,
    /// File of marks: lines `output,x,y,azimuth,elevation`
    #[arg(long, value_name = "FILE.csv")]
    marks: Option<PathBuf>,
    /// Rig file to write: the same rig with the results
    #[arg(short = 'o', long = "out", value_name = "FILE.toml", required_unless_present_any = ["patterns", "camera"])]
    out: Option<PathBuf>,
    /// Picture to write: the grid of the dome as the projectors show it, before and after
    #[arg(long, value_name = "FILE.png", requires = "out")]
    picture: Option<PathBuf>,
    /// Other unknown numbers of the projectors, besides their pose: fov, shift, radial, tangential,
    /// mirror
    #[arg(long, value_name = "PART,…", value_delimiter = ',', value_parser = part)]
    solve: Vec<Part>,
    /// A measured length, if the radius of the dome is not known: the distance of two outputs, or
    /// of one and the `camera`. The radius is computed
    #[arg(long, value_name = "FROM,TO,METRES", value_parser = length::length)]
    length: Option<length::Length>,
    /// Size of the smallest squares of the patterns in pixels of an output
    #[arg(long, value_name = "PIXELS", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    cell: u32,
    /// Also find the brightness of the projectors, from grey pictures: response, black, and masks
    /// that even out the light
    #[arg(long)]
    light: bool,
    /// Values of the photographs are proportional to light [default: sRGB]
    #[arg(long, requires = "light")]
    linear: bool,
    /// Window size in pixels [default: from the rig, or 1920x1200]
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size)]
    size: Option<(u32, u32)>,
    /// Replace the file if it exists
    #[arg(long)]
    force: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Reads the name of a part of a projector.
pub fn part(word: &str) -> Result<Part, String> {
    let words = || Part::ALL.map(Part::word).join(", ");
    Part::ALL.into_iter().find(|part| part.word() == word).ok_or_else(|| format!("expected one or more of {}", words()))
}

/// A solved output.
struct Found {
    /// Number of the output in the rig.
    output: usize,
    solved: Solved,
    /// Lines of the file of marks; empty for photographs.
    lines: Vec<usize>,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let rig = rig::load(&arguments.rig)?.with_all_outputs().into_owned();
    if let Some(folder) = &arguments.patterns {
        return patterns::write(arguments, &rig, folder);
    }
    if let Some(out) = &arguments.out {
        if out.extension().is_none_or(|ending| ending != "toml") {
            return Err(Failure::usage(format!("--out {}: expected a file name that ends in .toml", out.display())));
        }
        convert::refuse_to_replace(out, arguments.force)?;
    }
    if let Some(picture) = &arguments.picture {
        if picture.extension().is_none_or(|ending| ending != "png") {
            let file = picture.display();
            return Err(Failure::usage(format!("--picture {file}: expected a file name that ends in .png")));
        }
        convert::refuse_to_replace(picture, arguments.force)?;
    }
    // Mistakes in marks are found before photographs are made.
    let marks = arguments.marks.as_deref().map(|file| marks::read(file, &rig)).transpose()?.unwrap_or_default();
    if let Some((command, folder)) = arguments.camera.as_ref().zip(arguments.photos.as_ref()) {
        let count = shooting::run(arguments, &rig, command, folder)?;
        if arguments.out.is_none() {
            match arguments.json {
                true => println!("{:#}", json!({ "folder": folder.display().to_string(), "photographs": count })),
                false => println!("{}: {count} photographs", folder.display()),
            }
            return Ok(ExitCode::SUCCESS);
        }
    }
    solve(arguments, &rig, &marks, arguments.out.as_deref().unwrap_or(Path::new("")))
}

/// Solves the rig from marks or photographs, and writes it to `out`.
fn solve(arguments: &Arguments, rig: &Rig, marks: &[marks::Line], out: &Path) -> Result<ExitCode, Failure> {
    // The pose is always free.
    let mut parts = Part::ALL.to_vec();
    parts.retain(|part| *part == Part::Pose || arguments.solve.contains(part));
    let (mut found, mut camera, fitted, light) = match &arguments.photos {
        Some(folder) => {
            let found = photographs::solve(arguments, rig, folder, marks, &parts)?;
            (found.outputs, Some(found.camera), found.marks, found.light)
        }
        None if arguments.light => {
            return Err(Failure::usage("--light needs photographs of the patterns; give --photos DIR"));
        }
        None => (from_marks(arguments, rig, marks, &parts)?, None, Vec::new(), None),
    };
    let masks = light.as_ref().map(|light| light::masks(rig, light, out, arguments.force)).transpose()?;
    let length = arguments.length.as_ref();
    let radius = length.map(|length| length.apply(rig, &mut found, camera.as_mut())).transpose()?;
    written::write(&arguments.rig, rig, &parts, &found, radius, masks.as_deref().unwrap_or_default(), out)?;
    if let Some(picture) = &arguments.picture {
        let after = rig::load(&out.display().to_string())?.with_all_outputs().into_owned();
        compared::write(picture, rig, &after)?;
    }
    if arguments.json {
        let mut json = report::json(rig, &found, camera.as_ref(), light.as_ref(), out);
        json["marks"] = report::marks_json(&fitted);
        json["radius"] = json!(radius);
        println!("{json:#}");
        return Ok(ExitCode::SUCCESS);
    }
    println!("{}: outputs: {}", out.display(), found.len());
    found.iter().for_each(|found| print!("{}", report::words(rig, found, arguments.marks.as_deref())));
    if let Some(camera) = &camera {
        println!("{}", report::camera_words(camera));
    }
    print!("{}", report::marks_words(&fitted, arguments.marks.as_deref()));
    if let Some(radius) = radius {
        println!("dome: radius {radius:.4} m");
    }
    if let Some(light) = &light {
        print!("{}", report::light_words(rig, light));
    }
    Ok(ExitCode::SUCCESS)
}

/// Solves each output that has marks.
fn from_marks(arguments: &Arguments, rig: &Rig, marks: &[marks::Line], parts: &[Part]) -> Result<Vec<Found>, Failure> {
    let file = arguments.marks.as_deref().unwrap_or(Path::new("")).display();
    if let Some(line) = marks.iter().find(|line| line.mark.is_none()) {
        return Err(Failure::usage(format!("{file}:{}: there are no photographs; give --photos DIR", line.number)));
    }
    let own = |output: usize| -> (Vec<Mark>, Vec<usize>) {
        let own = marks.iter().filter_map(|line| Some((line.mark?, line.number)));
        own.filter(|(mark, _)| mark.output == output).unzip()
    };
    let outputs: Vec<usize> = (0..rig.outputs.len()).filter(|output| !own(*output).0.is_empty()).collect();
    let bar = terminal::progress(outputs.len() as u64, "outputs");
    let solve = |output: usize| {
        let (places, lines) = own(output);
        let solved = cupola::calibrate::marks::solve(rig, output, native_size(rig, output), &places, parts)
            .map_err(|error| Failure::usage(format!("{file}: {}", error.message)))?;
        bar.inc(1);
        Ok(Found { output, solved, lines })
    };
    let found = outputs.into_iter().map(solve).collect();
    bar.finish_and_clear();
    found
}
