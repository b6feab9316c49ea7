//! Solves a projector from marks: places of its picture whose direction in the dome is known.

use super::least_squares::{self, Fit, Model, median};
use super::{Part, Projector, Symmetric};
use crate::error::{Error, ErrorKind, Result};
use crate::geom::{Optics, Screen};
use crate::rig::Rig;
use glam::{DMat3, DVec2, DVec3};

/// A place of an output's picture, and its direction in the dome.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Number of the output.
    pub output: usize,
    /// The place, pixels from the top left.
    pub pixel: DVec2,
    /// The direction from the dome's centre, dome axes, unit length.
    pub direction: DVec3,
}

/// A projector that was solved.
#[derive(Clone, Debug)]
pub struct Solved {
    /// The optics.
    pub optics: Optics,
    /// Errors to expect of the optics.
    pub quality: Quality,
}

/// Errors to expect of a solved projector.
#[derive(Clone, Debug)]
pub struct Quality {
    /// Distance of each mark from its predicted place, pixels; ∞ where none is predicted.
    pub distances: Vec<f64>,
    /// True for each mark that had an influence on the result.
    pub used: Vec<bool>,
    /// Root mean square of the distances of used marks, pixels.
    pub rms: f64,
    /// Root mean square of the angles between used marks and the points that their pixels light, as
    /// seen from the dome's centre, radians.
    pub rms_angle: f64,
    /// Standard errors of the position along dome axes, metres.
    pub position: DVec3,
    /// Standard errors of the rotations about the projector's right, up and forward axes, radians.
    pub aim: DVec3,
    /// Covariance of the position along dome axes, metres, and of the rotations about the
    /// projector's right, up and backward axes, radians. 0 for numbers that were not searched.
    pub covariance: [[f64; 6]; 6],
    /// Expected error over the whole picture because the numbers are not exact: root mean square,
    /// pixels.
    pub expected: f64,
}

/// Number of poses that are tried as a start, and of marks in each.
const SAMPLES: usize = 60;
const SAMPLE: usize = 4;
/// Columns and rows of the places at which the expected error is computed.
const GRID: u32 = 9;

/// Solves the projector of one output. `marks` are only those of this output; `parts` are free.
///
/// The start is the rig's pose or a pose that fits four of the marks, whichever has the least
/// median distance (Rousseeuw 1984), so that neither wrong marks nor a rough rig mislead it.
///
/// # Errors
/// [`ErrorKind::InvalidArgument`] if the output is no projector with such parts, or the marks do
/// not determine it.
pub fn solve(rig: &Rig, output: usize, size: (u32, u32), marks: &[Mark], parts: &[Part]) -> Result<Solved> {
    let described = &rig.outputs[output];
    let invalid = |why: String| Error::new(ErrorKind::InvalidArgument, format!("output \"{}\" {why}", described.name));
    let screen = rig.surface();
    let projector = Projector::new(described, size, parts, screen.size())?;
    let needed = (projector.parameters() / 2 + 2).max(SAMPLE + 1);
    if marks.len() < needed {
        return Err(invalid(format!(
            "has {} marks; with these free numbers ({}) it needs {needed}, and twice as many to find wrong ones",
            marks.len(),
            parts.iter().map(|part| part.word()).collect::<Vec<_>>().join(", ")
        )));
    }
    let whole = MarksModel { points: points(&screen, &described.name, marks)?, projector };
    let start = start(&whole);
    let model = MarksModel { projector: whole.projector.with(start, parts), ..whole };
    let fit = least_squares::robust(&model, vec![0.0; model.parameters()]);
    let optics = model.projector.optics(&fit.parameters);
    let angle = |index: usize| {
        let (origin, direction) = model.projector.ray(&optics, marks[index].pixel)?;
        Some(screen.unbounded_hit(origin, direction)?.point.angle_between(marks[index].direction))
    };
    let own: Vec<usize> = (0..marks.len()).collect();
    let quality = quality(&model.projector, &fit, 0, &screen, &own, angle);
    quality.map(|quality| Solved { optics, quality }).ok_or_else(|| {
        invalid(
            "is not determined by its marks: spread them over the whole picture, at different azimuths and elevations"
                .into(),
        )
    })
}

/// Least error that any way to solve a projector can have with such marks (Cramér, Rao): root mean
/// square over the picture, pixels. `None` if the marks do not determine it.
///
/// `rig` and `marks` are exact; `deviation` is the standard deviation of the errors that the marks'
/// coordinates will have, pixels.
///
/// # Errors
/// As [`solve`].
pub fn limit(
    rig: &Rig,
    output: usize,
    size: (u32, u32),
    marks: &[Mark],
    parts: &[Part],
    deviation: f64,
) -> Result<Option<f64>> {
    let (described, screen) = (&rig.outputs[output], rig.surface());
    let projector = Projector::new(described, size, parts, screen.size())?;
    let model = MarksModel { points: points(&screen, &described.name, marks)?, projector };
    let exact = vec![0.0; model.parameters()];
    let information = least_squares::information(&model, &exact, &vec![true; marks.len()], &[deviation]);
    let Some(covariance) = information.inverse() else { return Ok(None) };
    Ok(Some(expected(&model.projector, &exact, &covariance, &screen)))
}

/// Places of marks with the points of the screen that they light.
fn points(screen: &Screen, name: &str, marks: &[Mark]) -> Result<Vec<(DVec2, DVec3)>> {
    let point = |mark: &Mark| {
        let hit = screen.unbounded_hit(DVec3::ZERO, mark.direction);
        hit.map(|hit| (mark.pixel, hit.point)).ok_or_else(|| {
            let [azimuth, elevation] = angles(mark.direction);
            let why = format!(
                "output \"{name}\" has a mark at azimuth {azimuth:.2}, elevation {elevation:.2}, where no screen is"
            );
            Error::new(ErrorKind::InvalidArgument, why)
        })
    };
    marks.iter().map(point).collect()
}

/// Root mean square distance, in pixels, between the places where `found` and `right` show the same
/// points, all over the picture of `projector`.
pub fn difference(projector: &Projector, right: &Optics, found: &Optics, screen: &Screen) -> f64 {
    rms(grid(projector.size()).filter_map(|pixel| {
        let (origin, direction) = projector.ray(right, pixel)?;
        let point = screen.hit(origin, direction)?.point;
        Some(projector.pixel(found, point)?.distance(pixel))
    }))
}

/// Azimuth and elevation of a direction, degrees.
fn angles(direction: DVec3) -> [f64; 2] {
    [direction.x.atan2(-direction.z).to_degrees(), direction.y.atan2(direction.x.hypot(direction.z)).to_degrees()]
}

/// Quality of a fitted projector, from its own observations. Its parameters begin at index `first`
/// of the fit; `angle` is the error of an observation on the dome. `None` if the parameters are not
/// determined.
pub(super) fn quality(
    projector: &Projector,
    fit: &Fit,
    first: usize,
    screen: &Screen,
    own: &[usize],
    angle: impl Fn(usize) -> Option<f64>,
) -> Option<Quality> {
    let covariance = fit.covariance.as_ref()?;
    let distance = |index: usize| fit.residuals[index].map_or(f64::INFINITY, DVec2::length);
    let used = || own.iter().copied().filter(|index| fit.used[*index]);
    let parameters = first..first + projector.parameters();
    let own_covariance = covariance.part(parameters.clone());
    let pose = pose_covariance(projector, &fit.parameters[parameters.clone()], &own_covariance);
    let error = |index: usize| pose[index][index].sqrt();
    Some(Quality {
        distances: own.iter().map(|index| distance(*index)).collect(),
        used: own.iter().map(|index| fit.used[*index]).collect(),
        rms: rms(used().map(distance)),
        rms_angle: rms(used().filter_map(angle)),
        position: DVec3::from_array([0, 1, 2].map(error)),
        aim: DVec3::from_array([3, 4, 5].map(error)),
        covariance: pose,
        expected: expected(projector, &fit.parameters[parameters], &own_covariance, screen),
    })
}

/// Covariance of a projector's position and rotation at these parameters; 0 for numbers that are not estimated.
fn pose_covariance(projector: &Projector, parameters: &[f64], covariance: &Symmetric) -> [[f64; 6]; 6] {
    let Some(range) = projector.range(Part::Pose) else { return [[0.0; 6]; 6] };
    let part = covariance.part(range.clone());
    // The parameters turn the pose of the start; the result is for rotations of the pose that was found.
    let turn = rotation_derivative(DVec3::from_slice(&parameters[range][3..]));
    let derivative = |row: usize, column: usize| match (row < 3, column < 3) {
        (true, true) if row == column => projector.unit(),
        (false, false) => turn.col(column - 3)[row - 3],
        _ => 0.0,
    };
    let spread = |row: usize, column: usize| (0..6).map(|k| part.at(row, k) * derivative(column, k)).sum::<f64>();
    let entry = |row: usize, column: usize| (0..6).map(|k| derivative(row, k) * spread(k, column)).sum();
    std::array::from_fn(|row| std::array::from_fn(|column| entry(row, column)))
}

/// Derivative of a rotation, as a rotation about its own axes, by its rotation vector (the right Jacobian of the
/// rotations).
fn rotation_derivative(vector: DVec3) -> DMat3 {
    let angle = vector.length();
    if angle < 1e-9 {
        return DMat3::IDENTITY;
    }
    let (sine, cosine) = angle.sin_cos();
    let cross = DMat3::from_cols(
        DVec3::new(0.0, vector.z, -vector.y),
        DVec3::new(-vector.z, 0.0, vector.x),
        DVec3::new(vector.y, -vector.x, 0.0),
    );
    DMat3::IDENTITY - (1.0 - cosine) / angle.powi(2) * cross + (angle - sine) / angle.powi(3) * cross * cross
}

/// Root mean square.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| (sum + value * value, count + 1));
    (sum / count.max(1) as f64).sqrt()
}

/// Expected error over the picture, pixels, from the covariance of a projector's own parameters.
pub(super) fn expected(projector: &Projector, parameters: &[f64], covariance: &Symmetric, screen: &Screen) -> f64 {
    let optics = projector.optics(parameters);
    let mut parameters = parameters.to_vec();
    let shown = |pixel: DVec2| {
        let (origin, direction) = projector.ray(&optics, pixel)?;
        Some(screen.hit(origin, direction)?.point)
    };
    let points: Vec<DVec3> = grid(projector.size()).filter_map(shown).collect();
    // Derivatives of the two coordinates of each point.
    let mut slopes = vec![[const { Vec::new() }; 2]; points.len()];
    const STEP: f64 = 1e-6;
    for index in 0..parameters.len() {
        let [after, before] = [STEP, -2.0 * STEP].map(|step| {
            parameters[index] += step;
            projector.optics(&parameters)
        });
        parameters[index] += STEP;
        for (point, slope) in points.iter().zip(&mut slopes) {
            let ends = projector.pixel(&after, *point).zip(projector.pixel(&before, *point));
            let by = ends.map_or(DVec2::ZERO, |(after, before)| (after - before) / (2.0 * STEP));
            slope[0].push(by.x);
            slope[1].push(by.y);
        }
    }
    let variance = |slope: &[Vec<f64>; 2]| covariance.form(&slope[0]) + covariance.form(&slope[1]);
    rms(slopes.iter().map(|slope| variance(slope).sqrt()))
}

/// Places all over a picture.
fn grid((width, height): (u32, u32)) -> impl Iterator<Item = DVec2> {
    let part = |index: u32| (f64::from(index) + 0.5) / f64::from(GRID);
    (0..GRID * GRID)
        .map(move |index| DVec2::new(part(index % GRID) * f64::from(width), part(index / GRID) * f64::from(height)))
}

/// Optics whose pose is near enough for a fit of all numbers.
fn start(whole: &MarksModel) -> Optics {
    let pose = whole.projector.with(whole.projector.optics(&[]), &[Part::Pose]);
    let score = |optics: &Optics| {
        let distance = |(pixel, point): &(DVec2, DVec3)| {
            whole.projector.pixel(optics, *point).map_or(f64::INFINITY, |found| found.distance(*pixel))
        };
        median(&mut whole.points.iter().map(distance).collect::<Vec<_>>())
    };
    let mut best = pose.optics(&[]);
    let mut least = score(&best);
    let mut random = 1u64;
    for _ in 0..SAMPLES {
        let mut left: Vec<usize> = (0..whole.points.len()).collect();
        let points = (0..SAMPLE).map(|_| whole.points[left.swap_remove(next(&mut random) % left.len())]).collect();
        let sample = MarksModel { projector: pose.clone(), points };
        let optics = pose.optics(&least_squares::squares(&sample, vec![0.0; 6]));
        let own = score(&optics);
        if own < least {
            (best, least) = (optics, own);
        }
    }
    best
}

/// A random number, the same in each run (a linear congruential generator, Knuth's MMIX).
fn next(state: &mut u64) -> usize {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) as usize
}

/// One projector, and places of its picture with their points.
struct MarksModel {
    projector: Projector,
    points: Vec<(DVec2, DVec3)>,
}

impl Model for MarksModel {
    type State = Optics;

    fn parameters(&self) -> usize {
        self.projector.parameters()
    }

    fn observations(&self) -> usize {
        self.points.len()
    }

    fn state(&self, parameters: &[f64]) -> Optics {
        self.projector.optics(parameters)
    }

    fn residual(&self, optics: &Optics, observation: usize) -> Option<DVec2> {
        let (pixel, point) = self.points[observation];
        Some(self.projector.pixel(optics, point)? - pixel)
    }

    fn depends(&self, _: usize) -> impl Iterator<Item = usize> {
        0..self.parameters()
    }
}

#[cfg(test)]
mod tests;
