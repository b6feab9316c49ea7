//! Photographs of the patterns.

use super::marks::Line;
use super::patterns::Patterns;
use super::{Arguments, Found, report};
use crate::failure::Failure;
use crate::map::native_size;
use crate::terminal;
use cupola::blend;
use cupola::calibrate::gray::{self, Codes, Decoder, Photograph, Picture};
use cupola::calibrate::light::{self, LEVELS, Reading};
use cupola::calibrate::{Camera, Observed, Part, Sighting, joint};
use cupola::rig::{Blend, OutputKind, Rig, Transfer};
use std::path::{Path, PathBuf};

/// Results from photographs.
pub struct Photographed {
    pub outputs: Vec<Found>,
    pub camera: Camera,
    /// The marks.
    pub marks: Vec<report::Fitted>,
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
    let patterns = Patterns::new(rig, arguments)?;
    let (files, count) = (files(folder)?, patterns.count());
    if files.len() != count {
        return Err(wrong_number(arguments, rig, folder, [files.len(), count]));
    }
    let mut observed = Observed::default();
    let mut readings = Vec::new();
    let values = values(arguments.linear);
    let bar = terminal::progress(count as u64, "photographs");
    let mut files = files.iter();
    for (output, codes) in patterns.outputs() {
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
    for (output, _) in
        patterns.outputs().iter().filter(|(output, _)| found.outputs.iter().all(|(own, _)| own != output))
    {
        eprintln!("cupola: {} is not in the photographs, and stays as it is", rig.outputs[*output].name);
    }
    let (mut landmarks, mut of_outputs) = (found.landmarks.iter(), found.marks.iter());
    let fitted = marks.iter().filter_map(|line| {
        let fitted = match line.mark {
            Some(_) => of_outputs.next().copied().flatten(),
            None => landmarks.next().copied(),
        };
        fitted.map(|fitted| report::Fitted { line: line.number, in_photograph: line.mark.is_none(), fitted })
    });
    let marks = fitted.collect();
    let light = arguments.light.then(|| solved_light(rig, &sizes, &found, &readings)).transpose();
    let light = light.map_err(|error| Failure::usage(format!("{}: {}", folder.display(), error.message)))?;
    let outputs = found.outputs.into_iter().map(|(output, solved)| Found { output, solved, lines: Vec::new() });
    Ok(Photographed { outputs: outputs.collect(), camera: found.camera, marks, light })
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
pub fn files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
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

/// Reads a photograph.
pub fn read(file: &Path) -> Result<Photograph, Failure> {
    let unreadable = |why: String| Failure::usage(format!("{} cannot be read: {why}", file.display()));
    let reader = image::ImageReader::open(file).map_err(|error| unreadable(error.to_string()))?;
    let image = reader.decode().map_err(|error| unreadable(error.to_string()))?.into_luma16();
    Ok(Photograph { size: image.dimensions(), values: image.into_raw() })
}
