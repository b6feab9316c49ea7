//! Patterns for a camera, and its photographs of them.

use super::marks::Line;
use super::{Arguments, Found};
use crate::failure::Failure;
use crate::map::native_size;
use crate::terminal;
use cupola::calibrate::gray::{Codes, Decoder, Photograph, Picture};
use cupola::calibrate::{Camera, Observed, Part, joint};
use cupola::rig::{self, Rig};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Side of the windows of an output in which places are averaged, cells. In larger ones the mean is
/// off, because the map is not straight.
const WINDOW: u32 = 4;

/// The outputs that get patterns, with their codes.
fn series(rig: &Rig, cell: u32) -> Vec<(usize, Codes)> {
    let projectors = (0..rig.outputs.len()).filter(|output| rig.outputs[*output].kind.is_projector());
    projectors.map(|output| (output, Codes::new(native_size(rig, output), cell))).collect()
}

fn no_projectors(rig: &Rig) -> Failure {
    Failure::usage(format!("the rig {} has no outputs of kind = \"projector\"", rig.name))
}

/// Writes the patterns of all outputs in the order in which they are photographed.
pub fn write_patterns(arguments: &Arguments, folder: &Path) -> Result<ExitCode, Failure> {
    let rig = rig::load(&arguments.rig)?;
    let series = series(&rig, arguments.cell);
    if series.is_empty() {
        return Err(no_projectors(&rig));
    }
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::usage(format!("the folder {} cannot be created: {error}", folder.display())))?;
    let window = arguments.size.or_else(|| rig.extent()).unwrap_or((1920, 1200));
    let places = rig.layout(window);
    let count: usize = series.iter().map(|(_, codes)| codes.pictures().len()).sum();
    let bar = terminal::progress(count as u64, "patterns");
    let mut number = 0;
    for (output, codes) in &series {
        let place = &places[*output];
        for picture in codes.pictures() {
            number += 1;
            let white = |x: u32, y: u32| {
                let inside = x >= place.x && y >= place.y && x - place.x < place.width && y - place.y < place.height;
                inside && codes.is_white(picture, (x - place.x, y - place.y))
            };
            let values: Vec<u8> =
                (0..window.0 * window.1).map(|at| 255 * u8::from(white(at % window.0, at / window.0))).collect();
            let file = folder.join(format!("{number:04}-{}-{}.png", rig.outputs[*output].name, name(picture)));
            image::save_buffer(&file, &values, window.0, window.1, image::ColorType::L8)
                .map_err(|error| Failure::new(format!("{} cannot be written: {error}", file.display())))?;
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    let folder = folder.display();
    if arguments.json {
        println!("{:#}", json!({ "folder": folder.to_string(), "patterns": count, "window": [window.0, window.1] }));
    } else {
        println!("{folder}: {count} patterns of {} × {} pixels; photograph them in this order", window.0, window.1);
    }
    Ok(ExitCode::SUCCESS)
}

fn name(picture: Picture) -> String {
    match picture {
        Picture::White => "white".to_owned(),
        Picture::Black => "black".to_owned(),
        Picture::Bit { axis, bit, inverse } => {
            format!("{}{bit}{}", ["x", "y"][axis.min(1)], if inverse { "-inverse" } else { "" })
        }
    }
}

/// Solves all outputs together with the camera that made the photographs.
pub fn solve(
    arguments: &Arguments,
    rig: &Rig,
    folder: &Path,
    marks: &[Line],
    parts: &[Part],
) -> Result<(Vec<Found>, Camera), Failure> {
    let series = series(rig, arguments.cell);
    if series.is_empty() {
        return Err(no_projectors(rig));
    }
    let files = files(folder)?;
    let count: usize = series.iter().map(|(_, codes)| codes.pictures().len()).sum();
    if files.len() != count {
        return Err(Failure::usage(format!(
            "{} has {} photographs (*.png); the patterns of {} with --cell {} are {count}",
            folder.display(),
            files.len(),
            rig.name,
            arguments.cell
        )));
    }
    let mut observed = Observed::default();
    let bar = terminal::progress(count as u64, "photographs");
    let mut files = files.iter();
    for (output, codes) in &series {
        let decoder = decoded(*codes, &mut files, &mut observed.photograph, &bar)?;
        observed.sightings.extend(decoder.sightings(*output, WINDOW * arguments.cell));
    }
    bar.finish_and_clear();
    for line in marks {
        match line.mark {
            Some(mark) => observed.marks.push(mark),
            None => observed.landmarks.push((line.pixel, line.direction)),
        }
    }
    let sizes: Vec<(u32, u32)> = (0..rig.outputs.len()).map(|output| native_size(rig, output)).collect();
    let spinner = terminal::spinner("solving");
    let found = joint::solve(rig, &sizes, &observed, parts)
        .map_err(|error| Failure::usage(format!("{}: {}", folder.display(), error.message)))?;
    spinner.finish_and_clear();
    if found.aimed_by_first {
        let first = found.outputs.first().map_or("", |(output, _)| &rig.outputs[*output].name);
        eprintln!(
            "cupola: there are no marks: the aim of {first} is taken from the rig, and the whole dome turns with it. \
             Two marks at least (--marks) fix it"
        );
    }
    for (output, _) in series.iter().filter(|(output, _)| found.outputs.iter().all(|(own, _)| own != output)) {
        eprintln!("cupola: {} is not in the photographs, and stays as it is", rig.outputs[*output].name);
    }
    let outputs = found.outputs.into_iter();
    Ok((outputs.map(|(output, solved)| Found { output, solved, lines: Vec::new() }).collect(), found.camera))
}

/// The photographs of a folder by their names.
fn files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let unreadable = |error: std::io::Error| Failure::usage(format!("{} cannot be read: {error}", folder.display()));
    let entries = std::fs::read_dir(folder).map_err(unreadable)?.flatten().map(|entry| entry.path());
    let is_png = |path: &PathBuf| path.extension().is_some_and(|kind| kind.eq_ignore_ascii_case("png"));
    let mut files: Vec<PathBuf> = entries.filter(is_png).collect();
    files.sort();
    Ok(files)
}

/// Reads and decodes the photographs of one output.
fn decoded<'a>(
    codes: Codes,
    files: &mut impl Iterator<Item = &'a PathBuf>,
    size: &mut (u32, u32),
    bar: &indicatif::ProgressBar,
) -> Result<Decoder, Failure> {
    let mut next = || -> Result<(Photograph, String), Failure> {
        let file = files.next().ok_or_else(|| Failure::new("a photograph is missing"))?;
        let photograph = read(file)?;
        if *size == (0, 0) {
            *size = photograph.size;
        }
        if *size != photograph.size {
            let ((width, height), (x, y)) = (photograph.size, *size);
            let file = file.display();
            return Err(Failure::usage(format!(
                "{file} has {width} × {height} pixels, the first photograph {x} × {y}"
            )));
        }
        bar.inc(1);
        Ok((photograph, file.display().to_string()))
    };
    let unlike = |file: String| Failure::usage(format!("{file}: its size is not that of the others"));
    let ((white, _), (black, file)) = (next()?, next()?);
    let mut decoder = Decoder::new(codes, &white, &black).ok_or_else(|| unlike(file))?;
    for picture in codes.pictures() {
        if let Picture::Bit { axis, bit, inverse: false } = picture {
            let ((picture, _), (inverse, file)) = (next()?, next()?);
            if !decoder.add(axis, bit, &picture, &inverse) {
                return Err(unlike(file));
            }
        }
    }
    Ok(decoder)
}

fn read(file: &Path) -> Result<Photograph, Failure> {
    let unreadable = |why: String| Failure::usage(format!("{} cannot be read: {why}", file.display()));
    let reader = image::ImageReader::open(file).map_err(|error| unreadable(error.to_string()))?;
    let image = reader.decode().map_err(|error| unreadable(error.to_string()))?.into_luma16();
    Ok(Photograph { size: image.dimensions(), values: image.into_raw() })
}
