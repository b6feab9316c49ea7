//! Photographs of 12 megapixels, rendered, decoded and solved.

use super::lamps::{self, Evenness, Lamps};
use super::render::{CELL, Sight};
use super::world::{self, LENS, PHOTOGRAPH, PRESET, SIZE, World};
use crate::failure::Failure;
use crate::random::Random;
use crate::terminal;
use cupola::blend;
use cupola::calibrate::gray::{CELLS, Codes, Decoder, Photograph, Picture};
use cupola::calibrate::light::{self, LEVELS, Reading};
use cupola::calibrate::{Camera, Observed, Part, Sighting, joint};
use cupola::rig::{Blend, Transfer};
use glam::DVec2;
use serde_json::json;
use std::fmt::Write;
use std::time::Instant;

/// Standard deviation of clicks on marks in the photograph, pixels.
const CLICKS: f64 = 0.3;
/// Numbers of marks that are tried, and the part of all observations that are wrong.
const TRIES: [(usize, f64); 3] = [(20, 0.0), (100, 0.0), (100, 0.1)];
/// Number of times that the marks of a try are drawn. Their errors decide, so one draw says little.
const DRAWS: u32 = 6;

/// How photographs are taken, and what is free.
struct Setting {
    name: &'static str,
    preset: &'static str,
    /// Value of the brightest white in the middle of the sensor, as a part of the greatest value.
    exposure: f64,
    free: &'static [Part],
    /// True if grey pictures are photographed as well.
    light: bool,
}

const SETTINGS: [Setting; 5] = [
    Setting { name: "known lenses", preset: PRESET, exposure: 0.7, free: &[Part::Pose], light: true },
    Setting { name: "unknown lenses", preset: PRESET, exposure: 0.7, free: &LENS, light: false },
    Setting { name: "underexposed to a fifth", preset: PRESET, exposure: 0.14, free: &LENS, light: false },
    Setting { name: "overexposed twofold", preset: PRESET, exposure: 2.0, free: &LENS, light: false },
    Setting { name: "unknown mirror", preset: "idome", exposure: 0.7, free: &[Part::Pose, Part::Mirror], light: false },
];

/// Results for a setting.
pub struct Photographed {
    name: &'static str,
    photographs: usize,
    sightings: usize,
    /// Errors of the decoded places: root mean square, and length of the mean, pixels of the
    /// photographs.
    decoding: (f64, f64),
    rendering: f64,
    solved: Vec<Solved>,
    /// Evenness of white before and after, if grey pictures were photographed.
    evenness: Option<[Evenness; 2]>,
}

/// Results of one try, for all draws.
struct Solved {
    marks: usize,
    /// Part of all observations that are wrong.
    wrong: f64,
    /// Error of each output, pixels.
    errors: Vec<f64>,
    /// Least error that is possible (Cramér, Rao), pixels.
    limit: f64,
    /// Mean time of a solution.
    seconds: f64,
}

impl Photographed {
    /// Table of the results.
    pub fn table(&self) -> String {
        let (width, height) = PHOTOGRAPH;
        let mut table = format!(
            "\n{}: {} photographs of {width} × {height} pixels, {} sightings with {:.3} px rms of error (mean {:.3} \
             px); rendered and decoded in {:.0} s\n\n\
             | marks | wrong | error, px | limit, px | worst output, px | solved in, s |\n|---|---|---|---|---|---|\n",
            self.name, self.photographs, self.sightings, self.decoding.0, self.decoding.1, self.rendering
        );
        for Solved { marks, wrong, errors, limit, seconds } in &self.solved {
            let (wrong, error, worst) = (100.0 * wrong, rms(errors), greatest(errors));
            // Writing into a string cannot fail.
            let _ = writeln!(table, "| {marks} | {wrong:.0} % | {error:.4} | {limit:.4} | {worst:.4} | {seconds:.1} |");
        }
        for (when, Evenness { rms, most }) in ["before", "after"].iter().zip(self.evenness.iter().flatten()) {
            let _ = writeln!(table, "light {when}: {:.2} % rms, at most {:.2} %", 100.0 * rms, 100.0 * most);
        }
        table
    }

    /// The results as JSON.
    pub fn json(&self) -> serde_json::Value {
        let solved = self.solved.iter().map(|Solved { marks, wrong, errors, limit, seconds }| {
            let error = rms(errors);
            json!({
                "marks": marks, "wrong": wrong, "error": error, "limit": limit, "outputs": errors, "seconds": seconds,
            })
        });
        json!({
            "name": self.name, "photographs": self.photographs, "sightings": self.sightings, "seconds": self.rendering,
            "decoding_rms": self.decoding.0, "decoding_mean": self.decoding.1,
            "solved": solved.collect::<Vec<_>>(),
            "light": self.evenness.as_ref().map(|both| both.each_ref().map(|Evenness { rms, most }| [*rms, *most])),
        })
    }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn greatest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// Renders the photographs of all settings, decodes and solves them. `done` gets the results of
/// each.
pub fn measured(done: impl Fn(&Photographed)) -> Result<Vec<Photographed>, Failure> {
    let measured = |setting: &Setting| measured_with(setting).inspect(|found| done(found));
    SETTINGS.iter().map(measured).collect()
}

fn measured_with(setting: &Setting) -> Result<Photographed, Failure> {
    let mut random = Random::new(7);
    let world = World::new(setting.preset, setting.free, &mut random)?;
    let camera = world::camera(&world, &mut random);
    let lamps = Lamps::new(&world, &mut random)?;
    let begin = Instant::now();
    let Taken { observed, readings, photographs } = taken(setting, &world, &lamps, &camera, &mut random)?;
    let rendering = begin.elapsed().as_secs_f64();
    let decoding = decoding(&world, &camera, &observed)?;
    // Of each coordinate: sightings as they were decoded, clicks on marks.
    let deviations = [decoding.0 / 2f64.sqrt(), CLICKS, CLICKS];
    let solved =
        TRIES.iter().map(|(marks, wrong)| tried(setting, &world, &camera, &observed, (*marks, *wrong), deviations));
    let solved: Vec<Solved> = solved.collect::<Result<_, _>>()?;
    let evenness = setting.light.then(|| evenness(setting, &world, &lamps, &camera, &observed, &readings));
    let (name, sightings, evenness) = (setting.name, observed.sightings.len(), evenness.transpose()?);
    Ok(Photographed { name, photographs, sightings, decoding, rendering, solved, evenness })
}

/// What was seen in the photographs of a setting.
#[derive(Default)]
struct Taken {
    observed: Observed,
    readings: Vec<Reading>,
    photographs: usize,
}

fn taken(
    setting: &Setting,
    world: &World,
    lamps: &Lamps,
    camera: &Camera,
    random: &mut Random,
) -> Result<Taken, Failure> {
    let codes = Codes::new(SIZE, CELL);
    let outputs = world.exact.outputs.len();
    let greys = if setting.light { LEVELS.len() - 2 } else { 0 };
    let photographs = outputs * (codes.pictures().len() + greys);
    let bar = terminal::progress(photographs as u64, "photographs");
    let sight = Sight::new(world, lamps, camera, setting.exposure)?;
    let mut taken = Taken { photographs, ..Taken::default() };
    taken.observed.photograph = PHOTOGRAPH;
    let srgb = Blend { transfer: Transfer::Srgb, ..Blend::default() };
    let light = |value: u16| blend::light_of(f64::from(value) / f64::from(u16::MAX), &srgb, blend::GREEN) as f32;
    let light: Vec<f32> = (0..=u16::MAX).map(light).collect();
    let unlike = || Failure::new("photographs of different sizes");
    for output in 0..outputs {
        let mut take = |picture: Picture| {
            bar.inc(1);
            sight.photograph(output, 1.0, |cell| codes.is_white(picture, cell), random)
        };
        let (white, black) = (take(Picture::White), take(Picture::Black));
        let mut decoder = Decoder::new(codes, &white, &black).ok_or_else(unlike)?;
        for picture in codes.pictures() {
            if let Picture::Bit { axis, bit, inverse: false } = picture {
                let both = [false, true].map(|inverse| take(Picture::Bit { axis, bit, inverse }));
                decoder.add(axis, bit, &both[0], &both[1]).then_some(()).ok_or_else(unlike)?;
            }
        }
        let seen = decoder.sightings(output, CELLS * CELL);
        if setting.light {
            let mut means: Vec<Vec<f64>> = Vec::new();
            for level in LEVELS {
                let grey = |random: &mut Random| -> Photograph {
                    bar.inc(1);
                    let level = lamps.response(output, f64::from(level) / 255.0);
                    sight.photograph(output, level, |_| true, random)
                };
                let mean = match level {
                    0 => decoder.light(CELLS * CELL, &black, &light),
                    255 => decoder.light(CELLS * CELL, &white, &light),
                    _ => decoder.light(CELLS * CELL, &grey(random), &light),
                };
                means.push(mean.ok_or_else(unlike)?);
            }
            taken.readings.extend(seen.iter().enumerate().map(|(index, sighting)| Reading {
                output,
                pixel: sighting.pixel,
                seen: sighting.seen,
                light: std::array::from_fn(|level| means[level][index]),
            }));
        }
        taken.observed.sightings.extend(seen);
    }
    bar.finish_and_clear();
    Ok(taken)
}

/// Solves the sightings with random marks, [`DRAWS`] times, side by side.
fn tried(
    setting: &Setting,
    world: &World,
    camera: &Camera,
    observed: &Observed,
    (marks, wrong): (usize, f64),
    deviations: [f64; 3],
) -> Result<Solved, Failure> {
    let sizes = vec![SIZE; world.exact.outputs.len()];
    let draw = |seed: u32| -> Result<(Vec<f64>, Vec<f64>, f64), Failure> {
        let mut random = Random::new(100 + u64::from(seed));
        let (drawn, right) = drawn(world, camera, observed, (marks, wrong), &mut random);
        let begin = Instant::now();
        let found = joint::solve(&world.rough, &sizes, &drawn, setting.free)?;
        let seconds = begin.elapsed().as_secs_f64() / f64::from(DRAWS);
        let errors = found.outputs.iter().map(|(output, solved)| world.error(*output, &solved.optics));
        // Their derivatives are those of the exact places, from which these are a tenth of a pixel away.
        let limits = joint::limits(&world.exact, &sizes, &right, camera, setting.free, deviations)?;
        Ok((errors.collect::<Result<_, _>>()?, limits.into_iter().flatten().collect(), seconds))
    };
    let mut solved = Solved { marks, wrong, errors: Vec::new(), limit: 0.0, seconds: 0.0 };
    let mut limits = Vec::new();
    let draws: Vec<_> = std::thread::scope(|scope| {
        let running: Vec<_> = (0..DRAWS).map(|seed| scope.spawn(move || draw(seed))).collect();
        running.into_iter().map(|thread| thread.join()).collect()
    });
    for draw in draws {
        let (errors, least, seconds) = draw.map_err(|_| Failure::new("a solution ended by a panic"))??;
        solved.errors.extend(errors);
        limits.extend(least);
        solved.seconds += seconds;
    }
    solved.limit = rms(&limits);
    Ok(solved)
}

/// The sightings with marks, all with their errors; and those of them that are not wrong.
fn drawn(
    world: &World,
    camera: &Camera,
    observed: &Observed,
    (marks, wrong): (usize, f64),
    random: &mut Random,
) -> (Observed, Observed) {
    let landmarks = world::landmarks(world, camera, marks, random);
    let mut drawn = Observed { landmarks, ..observed.clone() };
    let mut right = Observed { sightings: Vec::new(), landmarks: Vec::new(), ..drawn.clone() };
    drawn.landmarks.iter_mut().for_each(|(seen, _)| *seen += CLICKS * random.gaussian());
    for sighting in &mut drawn.sightings {
        match random.range(0.0, 1.0) < wrong {
            true => sighting.seen += 200.0 * random.gaussian(),
            false => right.sightings.push(*sighting),
        }
    }
    for landmark in &mut drawn.landmarks {
        match random.range(0.0, 1.0) < wrong {
            true => landmark.0 += 200.0 * random.gaussian(),
            false => right.landmarks.push(*landmark),
        }
    }
    (drawn, right)
}

/// Evenness of white before and after, with the poses and the light that were found.
fn evenness(
    setting: &Setting,
    world: &World,
    lamps: &Lamps,
    camera: &Camera,
    observed: &Observed,
    readings: &[Reading],
) -> Result<[Evenness; 2], Failure> {
    let sizes = vec![SIZE; world.exact.outputs.len()];
    let (drawn, _) = drawn(world, camera, observed, TRIES[1], &mut Random::new(200));
    let found = joint::solve(&world.rough, &sizes, &drawn, setting.free)?;
    let rig = lamps::calibrated(&world.rough, &found);
    lamps.evenness(&rig, &light::solve(&rig, &sizes, &found.camera, readings)?)
}

/// Root mean square and mean of the differences between decoded places and exact ones.
fn decoding(world: &World, camera: &Camera, observed: &Observed) -> Result<(f64, f64), Failure> {
    let screen = world.exact.surface();
    let projectors: Vec<_> =
        (0..world.exact.outputs.len()).map(|output| world.projector(output)).collect::<Result<_, _>>()?;
    let error = |sighting: &Sighting| {
        let (projector, optics) = &projectors[sighting.output];
        let (origin, direction) = projector.ray(optics, sighting.pixel)?;
        Some(sighting.seen - camera.place(screen.unbounded_hit(origin, direction)?.point)?)
    };
    let errors: Vec<DVec2> = observed.sightings.iter().filter_map(error).collect();
    let count = errors.len().max(1) as f64;
    let square = errors.iter().map(|error| error.length_squared()).sum::<f64>() / count;
    Ok((square.sqrt(), (errors.iter().sum::<DVec2>() / count).length()))
}
