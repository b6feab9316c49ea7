//! Patterns for a camera, and its photographs of them.

use super::marks::Line;
use super::{Arguments, Found};
use crate::failure::Failure;
use crate::map::native_size;
use crate::terminal;
use cupola::blend;
use cupola::calibrate::gray::{self, Codes, Decoder, Photograph, Picture};
use cupola::calibrate::light::{self, LEVELS, Reading};
use cupola::calibrate::{Camera, Observed, Part, Sighting, joint};
use cupola::rig::{self, Blend, OutputKind, Rig, Transfer};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Outputs that get patterns, with their codes.
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
    let count: usize = series.iter().map(|(_, codes)| shown(codes, arguments.light).len()).sum();
    let bar = terminal::progress(count as u64, "patterns");
    let mut number = 0;
    for (output, codes) in &series {
        let place = &places[*output];
        for picture in shown(codes, arguments.light) {
            number += 1;
            let value = |x: u32, y: u32| {
                let inside = x >= place.x && y >= place.y && x - place.x < place.width && y - place.y < place.height;
                if inside { picture.value(codes, (x - place.x, y - place.y)) } else { 0 }
            };
            let values: Vec<u8> = (0..window.0 * window.1).map(|at| value(at % window.0, at / window.0)).collect();
            let file = folder.join(format!("{number:04}-{}-{}.png", rig.outputs[*output].name, picture.name()));
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

/// A picture to photograph.
#[derive(Clone, Copy)]
enum Shown {
    Code(Picture),
    Grey(u8),
}

/// Pictures of an output in their order.
fn shown(codes: &Codes, light: bool) -> Vec<Shown> {
    // White and black are the first two codes.
    let greys = LEVELS.into_iter().filter(|level| light && !matches!(level, 0 | 255)).map(Shown::Grey);
    codes.pictures().into_iter().map(Shown::Code).chain(greys).collect()
}

impl Shown {
    fn value(self, codes: &Codes, pixel: (u32, u32)) -> u8 {
        match self {
            Self::Code(picture) => 255 * u8::from(codes.is_white(picture, pixel)),
            Self::Grey(level) => level,
        }
    }

    fn name(self) -> String {
        match self {
            Self::Grey(level) => format!("grey-{level:03}"),
            Self::Code(Picture::White) => "white".to_owned(),
            Self::Code(Picture::Black) => "black".to_owned(),
            Self::Code(Picture::Bit { axis, bit, inverse }) => {
                format!("{}{bit}{}", ["x", "y"][axis.min(1)], if inverse { "-inverse" } else { "" })
            }
        }
    }
}

/// Results from photographs.
pub struct Photographed {
    pub outputs: Vec<Found>,
    pub camera: Camera,
    /// Brightness of the outputs, if grey pictures were photographed.
    pub light: Option<light::Found>,
}

/// Failure of a folder in which the number of photographs is not that of the patterns:
/// `[is, wanted]`.
fn wrong_number(arguments: &Arguments, rig: &Rig, folder: &Path, [is, wanted]: [usize; 2]) -> Failure {
    Failure::usage(format!(
        "{} has {is} photographs (*.png, *.jpg); the patterns of {} with --cell {}{} are {wanted}",
        folder.display(),
        rig.name,
        arguments.cell,
        if arguments.light { " and --light" } else { "" }
    ))
}

/// Solves all outputs together with the camera that made the photographs.
pub fn solve(
    arguments: &Arguments,
    rig: &Rig,
    folder: &Path,
    marks: &[Line],
    parts: &[Part],
) -> Result<Photographed, Failure> {
    let series = series(rig, arguments.cell);
    if series.is_empty() {
        return Err(no_projectors(rig));
    }
    let files = files(folder)?;
    let count: usize = series.iter().map(|(_, codes)| shown(codes, arguments.light).len()).sum();
    if files.len() != count {
        return Err(wrong_number(arguments, rig, folder, [files.len(), count]));
    }
    let mut observed = Observed::default();
    let mut readings = Vec::new();
    let values = values(arguments.linear);
    let bar = terminal::progress(count as u64, "photographs");
    let mut files = files.iter();
    for (output, codes) in &series {
        let mut photographs = Photographs { files: &mut files, size: &mut observed.photograph, bar: &bar };
        let (decoder, white, black) = photographs.decoded(*codes)?;
        let window = gray::CELLS * arguments.cell;
        let seen = decoder.sightings(*output, window);
        if arguments.light {
            readings.extend(photographs.readings(&decoder, window, &seen, [&black, &white], &values)?);
        }
        observed.sightings.extend(seen);
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
    let light = arguments.light.then(|| solved_light(rig, &sizes, &found, &readings)).transpose();
    let light = light.map_err(|error| Failure::usage(format!("{}: {}", folder.display(), error.message)))?;
    let outputs = found.outputs.into_iter().map(|(output, solved)| Found { output, solved, lines: Vec::new() });
    Ok(Photographed { outputs: outputs.collect(), camera: found.camera, light })
}

/// Solves the light of the solved projectors.
fn solved_light(
    rig: &Rig,
    sizes: &[(u32, u32)],
    found: &joint::Found,
    readings: &[Reading],
) -> cupola::Result<light::Found> {
    let mut calibrated = rig.clone();
    for (output, solved) in &found.outputs {
        calibrated.outputs[*output].kind =
            OutputKind::Optics { optics: Box::new(solved.optics.clone()), even_light: 0.0 };
    }
    light::solve(&calibrated, sizes, &found.camera, readings)
}

/// Light of each value of a photograph, 0…1.
fn values(linear: bool) -> Vec<f32> {
    let srgb = Blend { transfer: Transfer::Srgb, ..Blend::default() };
    let light = |value: f64| if linear { value } else { blend::light_of(value, &srgb, blend::GREEN) };
    (0..=u16::MAX).map(|value| light(f64::from(value) / f64::from(u16::MAX)) as f32).collect()
}

/// Photographs of a folder, sorted by their names.
fn files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let unreadable = |error: std::io::Error| Failure::usage(format!("{} cannot be read: {error}", folder.display()));
    let entries = std::fs::read_dir(folder).map_err(unreadable)?.flatten().map(|entry| entry.path());
    let is_photograph = |path: &PathBuf| {
        let kinds = ["png", "jpg", "jpeg"];
        path.extension().is_some_and(|kind| kinds.iter().any(|known| kind.eq_ignore_ascii_case(known)))
    };
    let mut files: Vec<PathBuf> = entries.filter(is_photograph).collect();
    files.sort();
    Ok(files)
}

/// Photographs in their order.
struct Photographs<'a, I> {
    files: &'a mut I,
    size: &'a mut (u32, u32),
    bar: &'a indicatif::ProgressBar,
}

impl<'a, I: Iterator<Item = &'a PathBuf>> Photographs<'_, I> {
    fn next(&mut self) -> Result<Photograph, Failure> {
        let file = self.files.next().ok_or_else(|| Failure::new("a photograph is missing"))?;
        let photograph = read(file)?;
        if *self.size == (0, 0) {
            *self.size = photograph.size;
        }
        if *self.size != photograph.size {
            let ((width, height), (x, y)) = (photograph.size, *self.size);
            let file = file.display();
            return Err(Failure::usage(format!(
                "{file} has {width} × {height} pixels, the first photograph {x} × {y}"
            )));
        }
        self.bar.inc(1);
        Ok(photograph)
    }

    /// Reads and decodes the codes of one output. Returns white and black as well.
    fn decoded(&mut self, codes: Codes) -> Result<(Decoder, Photograph, Photograph), Failure> {
        let (white, black) = (self.next()?, self.next()?);
        let mut decoder = Decoder::new(codes, &white, &black).ok_or_else(unlike)?;
        for picture in codes.pictures() {
            if let Picture::Bit { axis, bit, inverse: false } = picture {
                let (picture, inverse) = (self.next()?, self.next()?);
                decoder.add(axis, bit, &picture, &inverse).then_some(()).ok_or_else(unlike)?;
            }
        }
        Ok((decoder, white, black))
    }

    /// Reads the light of the sightings of an output from the grey pictures that follow.
    fn readings(
        &mut self,
        decoder: &Decoder,
        window: u32,
        seen: &[Sighting],
        [black, white]: [&Photograph; 2],
        values: &[f32],
    ) -> Result<Vec<Reading>, Failure> {
        let reading = |sighting: &Sighting| {
            let Sighting { output, pixel, seen } = *sighting;
            Reading { output, pixel, seen, light: [0.0; LEVELS.len()] }
        };
        let mut readings: Vec<Reading> = seen.iter().map(reading).collect();
        for (index, level) in LEVELS.into_iter().enumerate() {
            let means = match level {
                0 => decoder.light(window, black, values),
                255 => decoder.light(window, white, values),
                _ => decoder.light(window, &self.next()?, values),
            };
            let means = means.ok_or_else(unlike)?;
            readings.iter_mut().zip(means).for_each(|(reading, mean)| reading.light[index] = mean);
        }
        Ok(readings)
    }
}

/// Failure for other sizes. All sizes have been compared before.
fn unlike() -> Failure {
    Failure::new("the photographs are not of the same size")
}

fn read(file: &Path) -> Result<Photograph, Failure> {
    let unreadable = |why: String| Failure::usage(format!("{} cannot be read: {why}", file.display()));
    let reader = image::ImageReader::open(file).map_err(|error| unreadable(error.to_string()))?;
    let image = reader.decode().map_err(|error| unreadable(error.to_string()))?.into_luma16();
    Ok(Photograph { size: image.dimensions(), values: image.into_raw() })
}
