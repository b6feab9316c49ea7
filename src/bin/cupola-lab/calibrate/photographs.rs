//! Photographs of 12 megapixels, rendered, decoded and solved.
//!
//! A pixel of the photograph follows from the exact geometry, at 3 × 3 places in it. The lens is
//! out of focus and darker at its rim, the room is not quite dark, the picture sensor has shot
//! noise and read noise, and values are sRGB of 8 bits.

use super::world::{self, LENS, PHOTOGRAPH, SIZE, World};
use crate::failure::Failure;
use crate::random::Random;
use crate::terminal;
use cupola::calibrate::gray::{CELLS, Codes, Decoder, Photograph, Picture};
use cupola::calibrate::{Camera, Observed, Part, Sighting, joint};
use glam::{DVec2, DVec3};
use serde_json::json;
use std::fmt::Write;
use std::time::Instant;

/// Side of a cell, pixels of an output.
const CELL: u32 = 4;
/// Number of places in a pixel of the photograph, along each axis.
const SAMPLES: usize = 3;
/// Standard deviation of the lens' blur, pixels.
const BLUR: f64 = 0.8;
/// Light of the room, and light that the dome throws onto itself.
const AMBIENT: f64 = 0.004;
/// Noise of black, and number of electrons that saturate a pixel.
const READ: f64 = 0.002;
const ELECTRONS: f64 = 20_000.0;
/// Standard deviation of clicks on marks in the photograph, pixels.
const CLICKS: f64 = 0.3;
/// Numbers of marks that are tried, and the part of all observations that are wrong.
const TRIES: [(usize, f64); 3] = [(20, 0.0), (100, 0.0), (100, 0.1)];

/// Number of times that the marks of a try are drawn. Their errors decide, so one draw says little.
const DRAWS: u32 = 6;

/// How photographs are taken, and what is free.
struct Setting {
    name: &'static str,
    /// Value of white in the middle of the sensor, as a part of the greatest value.
    exposure: f64,
    free: &'static [Part],
}

const POSE: [Part; 1] = [Part::Pose];
const SETTINGS: [Setting; 4] = [
    Setting { name: "known lenses", exposure: 0.7, free: &POSE },
    Setting { name: "unknown lenses", exposure: 0.7, free: &LENS },
    Setting { name: "unknown lenses, underexposed to a fifth", exposure: 0.14, free: &LENS },
    Setting { name: "unknown lenses, overexposed to twice the range", exposure: 2.0, free: &LENS },
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
        })
    }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn greatest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// Renders the photographs of all settings, decodes and solves them.
pub fn measured() -> Result<Vec<Photographed>, Failure> {
    SETTINGS.iter().map(measured_with).collect()
}

fn measured_with(setting: &Setting) -> Result<Photographed, Failure> {
    let mut random = Random::new(7);
    let world = World::new(&mut random, setting.free)?;
    let camera = world::camera(&mut random);
    let codes = Codes::new(SIZE, CELL);
    let outputs = world.exact.outputs.len();
    let bar = terminal::progress((outputs * codes.pictures().len()) as u64, "photographs");
    let begin = Instant::now();
    let rays = rays(&camera);
    let mut observed = Observed { photograph: PHOTOGRAPH, ..Observed::default() };
    for output in 0..outputs {
        let scene = Scene::new(&world, output, &camera, &rays)?;
        let mut take = |picture: Picture| {
            bar.inc(1);
            scene.photograph(&codes, picture, setting.exposure, &mut random)
        };
        let (white, black) = (take(Picture::White), take(Picture::Black));
        let unlike = || Failure::new("photographs of different sizes");
        let mut decoder = Decoder::new(codes, &white, &black).ok_or_else(unlike)?;
        for picture in codes.pictures() {
            if let Picture::Bit { axis, bit, inverse: false } = picture {
                let both = [false, true].map(|inverse| take(Picture::Bit { axis, bit, inverse }));
                decoder.add(axis, bit, &both[0], &both[1]).then_some(()).ok_or_else(unlike)?;
            }
        }
        observed.sightings.extend(decoder.sightings(output, CELLS * CELL));
    }
    bar.finish_and_clear();
    let rendering = begin.elapsed().as_secs_f64();
    let decoding = decoding(&world, &camera, &observed)?;
    let sizes = vec![SIZE; outputs];
    // Of each coordinate: sightings as they were decoded, clicks on marks.
    let deviations = [decoding.0 / 2f64.sqrt(), CLICKS, CLICKS];
    let mut solved = Vec::new();
    for (marks, wrong) in TRIES {
        let (mut errors, mut limits, mut seconds) = (Vec::new(), Vec::new(), 0.0);
        for _ in 0..DRAWS {
            let mut drawn =
                Observed { landmarks: world::landmarks(&world, &camera, marks, &mut random), ..observed.clone() };
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
            let begin = Instant::now();
            let found = joint::solve(&world.rough, &sizes, &drawn, setting.free)?;
            seconds += begin.elapsed().as_secs_f64() / f64::from(DRAWS);
            for (output, solved) in &found.outputs {
                errors.push(world.error(*output, &solved.optics)?);
            }
            // Their derivatives are those of the exact places, from which these are a tenth of a pixel away.
            let least = joint::limits(&world.exact, &sizes, &right, &camera, setting.free, deviations)?;
            limits.extend(least.into_iter().flatten());
        }
        solved.push(Solved { marks, wrong, errors, limit: rms(&limits), seconds });
    }
    let (name, photographs, sightings) = (setting.name, outputs * codes.pictures().len(), observed.sightings.len());
    Ok(Photographed { name, photographs, sightings, decoding, rendering, solved })
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

/// Directions, dome axes, of the corners of all pixels of the photograph, row by row.
fn rays(camera: &Camera) -> Vec<DVec3> {
    let ray = |corner: DVec2| {
        // Uses the lens without coefficients; the place is moved until the lens with coefficients
        // sees the corner.
        let mut place = corner;
        for _ in 0..12 {
            let seen = camera.ideal_ray(place).and_then(|ray| camera.place(camera.pose.point_to_parent(ray)));
            let Some(seen) = seen else { break };
            place += corner - seen;
        }
        camera.pose.direction_to_parent(camera.ideal_ray(place).unwrap_or(DVec3::Z))
    };
    let (width, height) = PHOTOGRAPH;
    (0..=height).flat_map(|y| (0..=width).map(move |x| DVec2::new(f64::from(x), f64::from(y)))).map(ray).collect()
}

/// The camera's sight of one output.
struct Scene {
    /// Part of the photograph that the output lights: left, top, width, height.
    part: [usize; 4],
    /// Columns and rows of the cells at the places in each pixel of the part; `u16::MAX` beside the
    /// picture.
    cells: Vec<[[u16; 2]; SAMPLES * SAMPLES]>,
    /// Brightness of the lens for each pixel of the part.
    vignetting: Vec<f32>,
}

const NOTHING: [u16; 2] = [u16::MAX; 2];

impl Scene {
    fn new(world: &World, output: usize, camera: &Camera, rays: &[DVec3]) -> Result<Self, Failure> {
        let (projector, optics) = world.projector(output)?;
        let screen = world.exact.surface();
        let columns = PHOTOGRAPH.0 as usize + 1;
        let pixel = |ray: &DVec3| projector.pixel(&optics, screen.hit(camera.pose.position, *ray)?.point);
        let corners: Vec<Option<DVec2>> = rays.iter().map(pixel).collect();
        let is_lit = |place: &DVec2| {
            place.cmpge(DVec2::ZERO).all() && place.x < f64::from(SIZE.0) && place.y < f64::from(SIZE.1)
        };
        let lit = || corners.iter().enumerate().filter(|(_, place)| place.as_ref().is_some_and(is_lit));
        let edge = |of: fn(usize, usize) -> usize| lit().map(move |(index, _)| of(index, columns));
        let (left, right) = (edge(|i, n| i % n).min().unwrap_or(0), edge(|i, n| i % n).max().unwrap_or(0));
        let (top, bottom) = (edge(|i, n| i / n).min().unwrap_or(0), edge(|i, n| i / n).max().unwrap_or(0));
        const MARGIN: usize = 8;
        let (left, top) = (left.saturating_sub(MARGIN), top.saturating_sub(MARGIN));
        let (right, bottom) = ((right + MARGIN).min(columns - 1), (bottom + MARGIN).min(PHOTOGRAPH.1 as usize));
        let part = [left, top, right - left, bottom - top];
        let mut scene = Self { part, cells: Vec::new(), vignetting: Vec::new() };
        for (y, x) in (top..bottom).flat_map(|y| (left..right).map(move |x| (y, x))) {
            let at = y * columns + x;
            let corners = [corners[at], corners[at + 1], corners[at + columns], corners[at + columns + 1]];
            scene.cells.push(cells(corners, is_lit));
            let away = DVec2::new(x as f64, y as f64).distance(camera.center) / (0.5 * f64::from(PHOTOGRAPH.1));
            scene.vignetting.push((1.0 - 0.4 * away.powi(2).min(2.0)) as f32);
        }
        Ok(scene)
    }

    /// Photograph of a picture.
    fn photograph(&self, codes: &Codes, picture: Picture, exposure: f64, random: &mut Random) -> Photograph {
        let [left, top, width, height] = self.part;
        let white = |cell: &[u16; 2]| {
            *cell != NOTHING && codes.is_white(picture, (u32::from(cell[0]) * CELL, u32::from(cell[1]) * CELL))
        };
        let light = self.cells.iter().map(|cells| cells.iter().filter(|cell| white(cell)).count() as f32);
        let light = blurred(&light.map(|count| count / (SAMPLES * SAMPLES) as f32).collect::<Vec<_>>(), width);
        let (columns, rows) = (PHOTOGRAPH.0 as usize, PHOTOGRAPH.1 as usize);
        let mut values = vec![encoded(exposure * AMBIENT); columns * rows];
        for index in 0..width * height {
            let exact = exposure * f64::from(self.vignetting[index]) * (f64::from(light[index]) + AMBIENT);
            let noise = (READ * READ + exact / ELECTRONS).sqrt() * random.gaussian().x;
            values[(top + index / width) * columns + left + index % width] = encoded(exact + noise);
        }
        Photograph { size: PHOTOGRAPH, values }
    }
}

/// Cells at the places in a pixel with these corners.
fn cells(corners: [Option<DVec2>; 4], is_lit: impl Fn(&DVec2) -> bool) -> [[u16; 2]; SAMPLES * SAMPLES] {
    let [Some(a), Some(b), Some(c), Some(d)] = corners else { return [NOTHING; SAMPLES * SAMPLES] };
    std::array::from_fn(|sample| {
        let part = |index: usize| (index as f64 + 0.5) / SAMPLES as f64;
        let (x, y) = (part(sample % SAMPLES), part(sample / SAMPLES));
        let place = a.lerp(b, x).lerp(c.lerp(d, x), y);
        if is_lit(&place) { [place.x, place.y].map(|at| (at as u32 / CELL) as u16) } else { NOTHING }
    })
}

/// A picture of rows of `width` pixels, blurred.
fn blurred(picture: &[f32], width: usize) -> Vec<f32> {
    let reach = (3.0 * BLUR).ceil() as usize;
    let weights: Vec<f32> =
        (0..=2 * reach).map(|at| (-0.5 * ((at as f64 - reach as f64) / BLUR).powi(2)).exp() as f32).collect();
    let sum: f32 = weights.iter().sum();
    let along = |picture: &[f32], step: usize| -> Vec<f32> {
        let border = reach * step;
        let mut blurred = vec![0.0; picture.len()];
        for (index, pixel) in blurred.iter_mut().enumerate().take(picture.len() - border).skip(border) {
            let taps = picture[index - border..].iter().step_by(step).zip(&weights);
            *pixel = taps.map(|(value, weight)| value * weight).sum::<f32>() / sum;
        }
        blurred
    };
    along(&along(picture, 1), width)
}

/// Encodes light as a value of 8 bits in sRGB, scaled to 16 bits.
fn encoded(light: f64) -> u16 {
    let light = light.clamp(0.0, 1.0);
    let value = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    257 * (255.0 * value + 0.5) as u16
}
