//! Error against noise for marks and for sightings, some of which are wrong.

use super::world::{self, LENS, PHOTOGRAPH, PRESET, SIZE, World};
use crate::failure::Failure;
use crate::random::Random;
use crate::terminal;
use cupola::calibrate::{Mark, Observed, Part, Sighting, joint, marks};
use serde_json::json;
use std::fmt::Write;

/// Standard deviations of each coordinate, pixels.
const NOISES: [f64; 5] = [0.03, 0.1, 0.3, 1.0, 3.0];
/// Number of observations for each wrong one.
const WRONG_EACH: usize = 10;
/// Number of marks of each projector.
const MARKS: usize = 60;
/// Number of sightings of each projector, and of marks in the photograph.
const SIGHTINGS: usize = 200;
const LANDMARKS: usize = 20;

/// Results of one way to calibrate.
pub struct Series {
    /// Description of the solved problem.
    pub name: String,
    /// Results, one for each noise.
    pub points: Vec<Point>,
}

/// Results for one noise, root mean squares over all outputs of all runs, pixels of the outputs.
#[derive(Default)]
pub struct Point {
    /// Standard deviation of a coordinate, pixels.
    pub noise: f64,
    /// Error over the picture.
    pub error: f64,
    /// Limit of Cramér and Rao.
    pub limit: f64,
    /// Error that the solver expects.
    pub told: f64,
    /// Greatest error of an output divided by its limit.
    pub worst: f64,
    outputs: u32,
    refused: u32,
}

impl Point {
    fn add(&mut self, error: f64, limit: f64, told: f64) {
        self.error += error * error;
        self.limit += limit * limit;
        self.told += told * told;
        self.worst = self.worst.max(error / limit);
        self.outputs += 1;
    }

    fn mean(self) -> Self {
        let root = |sum: f64| (sum / f64::from(self.outputs.max(1))).sqrt();
        Self { error: root(self.error), limit: root(self.limit), told: root(self.told), ..self }
    }
}

impl Series {
    /// Table for the documentation.
    pub fn table(&self) -> String {
        let mut table = format!(
            "\n{}\n\n| noise, px | error, px | limit, px | error ÷ limit | worst output | told, px | refused |\n|---|---|---|---|---|---|---|\n",
            self.name
        );
        for point in &self.points {
            // Writing into a string cannot fail.
            let _ = writeln!(
                table,
                "| {} | {:.4} | {:.4} | {:.3} | {:.2} | {:.4} | {} |",
                point.noise,
                point.error,
                point.limit,
                point.error / point.limit,
                point.worst,
                point.told,
                point.refused
            );
        }
        table
    }

    /// The results as JSON.
    pub fn json(&self) -> serde_json::Value {
        let points = self.points.iter().map(|point| {
            json!({
                "noise": point.noise, "error": point.error, "limit": point.limit, "told": point.told,
                "worst": point.worst,
                "outputs": point.outputs, "refused": point.refused,
            })
        });
        json!({ "name": self.name, "points": points.collect::<Vec<_>>() })
    }
}

/// All series with `runs` runs for each noise.
pub fn all(runs: u32) -> Result<Vec<Series>, Failure> {
    let bar = terminal::progress(3 * NOISES.len() as u64 * u64::from(runs), "runs");
    let series = |name: String, one: fn(&mut Point, &mut Random) -> Result<(), Failure>| {
        let point = |(number, noise): (usize, f64)| {
            let mut random = Random::new(1 + number as u64);
            let mut point = Point { noise, ..Point::default() };
            for _ in 0..runs {
                one(&mut point, &mut random)?;
                bar.inc(1);
            }
            Ok(point.mean())
        };
        let points = NOISES.into_iter().enumerate().map(point).collect::<Result<_, Failure>>()?;
        Ok::<_, Failure>(Series { name, points })
    };
    let of_photograph = |free: &str| {
        format!(
            "photograph: {SIGHTINGS} sightings of each projector, {LANDMARKS} marks, one of {WRONG_EACH} wrong; {free} free"
        )
    };
    let all = vec![
        series(format!("{MARKS} marks of each projector, one of {WRONG_EACH} wrong; pose and lens free"), by_marks)?,
        series(of_photograph("poses and the camera"), |point, random| by_sightings(point, random, &[Part::Pose]))?,
        series(of_photograph("poses, lenses and the camera"), |point, random| by_sightings(point, random, &LENS))?,
    ];
    bar.finish_and_clear();
    Ok(all)
}

/// Solves each output of a new rig from marks.
fn by_marks(point: &mut Point, random: &mut Random) -> Result<(), Failure> {
    let world = World::new(PRESET, &LENS, random)?;
    for output in 0..world.exact.outputs.len() {
        let (projector, optics) = world.projector(output)?;
        let mut all: Vec<Mark> = (0..MARKS)
            .map(|_| {
                let (pixel, lit) = world.lit(&projector, &optics, random);
                Mark { output, pixel, direction: lit.normalize() }
            })
            .collect();
        let right: Vec<Mark> =
            all.iter().copied().enumerate().filter(|(index, _)| !is_wrong(*index)).map(|(_, mark)| mark).collect();
        let limit = marks::limit(&world.exact, output, SIZE, &right, &LENS, point.noise)?;
        for (index, mark) in all.iter_mut().enumerate() {
            mark.pixel += error(index, point.noise, random);
        }
        match (marks::solve(&world.rough, output, SIZE, &all, &LENS), limit) {
            (Ok(solved), Some(limit)) => {
                point.add(world.error(output, &solved.optics)?, limit, solved.quality.expected);
            }
            _ => point.refused += 1,
        }
    }
    Ok(())
}

/// Solves all outputs of a new rig from a camera's sightings.
fn by_sightings(point: &mut Point, random: &mut Random, free: &[Part]) -> Result<(), Failure> {
    let world = World::new(PRESET, free, random)?;
    let camera = world::camera(&world, random);
    let mut all = Observed { photograph: PHOTOGRAPH, ..Observed::default() };
    for output in 0..world.exact.outputs.len() {
        let (projector, optics) = world.projector(output)?;
        let mut found = 0;
        while found < SIGHTINGS {
            let (pixel, lit) = world.lit(&projector, &optics, random);
            let Some(seen) = camera.place(lit).filter(|place| world::is_inside(*place)) else { continue };
            all.sightings.push(Sighting { output, pixel, seen });
            found += 1;
        }
    }
    all.landmarks = world::landmarks(&world, &camera, LANDMARKS, random);
    let mut right = all.clone();
    let mut index = 0..;
    right.sightings.retain(|_| index.next().is_some_and(|index| !is_wrong(index)));
    let mut index = 0..;
    right.landmarks.retain(|_| index.next().is_some_and(|index| !is_wrong(index)));
    let sizes = vec![SIZE; world.exact.outputs.len()];
    let limits = joint::limits(&world.exact, &sizes, &right, &camera, free, [point.noise; 3])?;
    for (index, sighting) in all.sightings.iter_mut().enumerate() {
        sighting.seen += error(index, point.noise, random);
    }
    for (index, (seen, _)) in all.landmarks.iter_mut().enumerate() {
        *seen += error(index, point.noise, random);
    }
    let (Ok(found), Some(limits)) = (joint::solve(&world.rough, &sizes, &all, free), limits) else {
        point.refused += sizes.len() as u32;
        return Ok(());
    };
    for ((output, solved), limit) in found.outputs.iter().zip(limits) {
        point.add(world.error(*output, &solved.optics)?, limit, solved.quality.expected);
    }
    Ok(())
}

fn is_wrong(index: usize) -> bool {
    index % WRONG_EACH == WRONG_EACH - 1
}

/// The error of an observation.
fn error(index: usize, noise: f64, random: &mut Random) -> glam::DVec2 {
    if is_wrong(index) { 200.0 * random.gaussian() + 30.0 } else { noise * random.gaussian() }
}
