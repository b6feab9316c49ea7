//! Error of any map against the exact one, in output pixels.

use super::WarpMap;
use glam::{DVec2, DVec3};

/// Distance around a pixel, in pixels, within which an edge of the shown area makes it an edge
/// pixel.
const EDGE: f64 = 0.01;

/// Error, in radians, above which the pixel may be on the border of two pictures that stand side by
/// side.
const LEAP: f64 = 0.01;

/// Errors of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapError {
    /// Number of pixels that both maps show; the errors below are theirs.
    pub compared: u64,
    /// Greatest error, output pixels.
    pub max: f64,
    /// Root mean square error, output pixels.
    pub rms: f64,
    /// Place of the greatest error: column and row, from the top left.
    pub worst: (u32, u32),
    /// Number of pixels whose direction is zero or not finite.
    pub non_finite: u64,
    /// Number of pixels that should show something and do not.
    pub uncovered: u64,
    /// Number of pixels that should show nothing and do, or that show a direction more than 90°
    /// away (behind).
    pub ghosts: u64,
    /// Number of pixels that are not compared, which is no fault: within 0.01 pixel of an edge of
    /// the shown area, where one map may show something and the other nothing, or of a border of a
    /// cubemap's faces, where they may show different faces.
    pub edge: u64,
}

impl MapError {
    /// True if no pixel is missing, false or not finite.
    pub fn is_sound(&self) -> bool {
        self.non_finite == 0 && self.uncovered == 0 && self.ghosts == 0
    }
}

/// Compares `map` (column, row → direction in viewer axes, any length; `None` where it shows
/// nothing) with `exact` at every `step`-th pixel (from 1) in both directions.
///
/// The error of a pixel is the angle between the two directions divided by the local angular size
/// of a pixel: the root mean square of the exact map's two steps, horizontal and vertical. Near a
/// singular point of a map (the rim of a 360° fisheye) this stays meaningful where a single step
/// shrinks to 0.
pub fn compare(exact: &WarpMap, step: u32, map: impl FnMut(u32, u32) -> Option<DVec3>) -> MapError {
    compare_each(exact, step, map, |_| {})
}

/// Error of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelError {
    /// Column and row, from the top left.
    pub pixel: (u32, u32),
    /// Error in output pixels.
    pub pixels: f64,
    /// Angle between the two directions, radians.
    pub angle: f64,
}

impl PixelError {
    /// Middle of the pixel.
    pub fn centre(&self) -> DVec2 {
        centre(self.pixel.0, self.pixel.1)
    }
}

/// As [`compare`]; `each` gets the error of every pixel that is counted.
pub fn compare_each(
    exact: &WarpMap,
    step: u32,
    map: impl FnMut(u32, u32) -> Option<DVec3>,
    each: impl FnMut(PixelError),
) -> MapError {
    compare_pixels(exact, |x, y| ExactPixel::of(exact, centre(x, y)), step, map, each)
}

/// The exact map around a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct ExactPixel {
    /// Direction at the pixel's middle.
    pub(super) direction: Option<DVec3>,
    /// Angle of the pixel, as [`pixel_angle`] defines it.
    angle: Option<f64>,
}

impl ExactPixel {
    pub(super) fn of(exact: &WarpMap, pixel: DVec2) -> Self {
        let direction = exact.direction(pixel);
        Self { direction, angle: direction.and_then(|direction| angle_around(exact, pixel, direction)) }
    }
}

/// Middle of a pixel.
pub(super) fn centre(x: u32, y: u32) -> DVec2 {
    DVec2::new(f64::from(x), f64::from(y)) + 0.5
}

/// As [`compare_each`]; `at` gives the pixels of `exact`.
pub(super) fn compare_pixels(
    exact: &WarpMap,
    at: impl Fn(u32, u32) -> ExactPixel,
    step: u32,
    mut map: impl FnMut(u32, u32) -> Option<DVec3>,
    mut each: impl FnMut(PixelError),
) -> MapError {
    let mut result = MapError::default();
    let mut sum_of_squares = 0.0;
    let step = step.max(1) as usize;
    let (width, height) = exact.size();
    for y in (0..height).step_by(step) {
        for x in (0..width).step_by(step) {
            let (pixel, expected) = (centre(x, y), at(x, y));
            match (expected.direction, map(x, y)) {
                (_, Some(found)) if !found.is_finite() || found == DVec3::ZERO => result.non_finite += 1,
                (None, None) => {}
                (Some(_), None) | (None, Some(_)) if is_edge(exact, pixel) => result.edge += 1,
                (Some(_), None) => result.uncovered += 1,
                (None, Some(_)) => result.ghosts += 1,
                (Some(direction), Some(found)) => {
                    // Scales first: the square of a length must neither overflow nor underflow.
                    let found = (found / found.abs().max_element()).normalize();
                    let angle = angle_between(found, direction);
                    if angle > LEAP && is_beside(exact, pixel, found) {
                        result.edge += 1;
                        continue;
                    }
                    if direction.dot(found) <= 0.0 {
                        result.ghosts += 1;
                        continue;
                    }
                    let Some(size) = expected.angle else {
                        result.edge += 1;
                        continue;
                    };
                    let error = angle / size;
                    each(PixelError { pixel: (x, y), pixels: error, angle });
                    result.compared += 1;
                    sum_of_squares += error * error;
                    if error > result.max {
                        (result.max, result.worst) = (error, (x, y));
                    }
                }
            }
        }
    }
    if result.compared > 0 {
        result.rms = (sum_of_squares / result.compared as f64).sqrt();
    }
    result
}

/// True if the shown area of the exact map begins or ends within [`EDGE`] of a pixel.
fn is_edge(exact: &WarpMap, pixel: DVec2) -> bool {
    let here = exact.direction(pixel).is_some();
    let around = [(EDGE, 0.0), (-EDGE, 0.0), (0.0, EDGE), (0.0, -EDGE)];
    around.into_iter().any(|(x, y)| exact.direction(pixel + DVec2::new(x, y)).is_some() != here)
}

/// True if the exact map shows `found`, of unit length, within [`EDGE`] of a pixel.
fn is_beside(exact: &WarpMap, pixel: DVec2, found: DVec3) -> bool {
    [EDGE, -EDGE].into_iter().any(|x| {
        let at = |part: f64| exact.direction(pixel + DVec2::new(part * x, 0.0));
        match (at(1.0), at(2.0)) {
            (Some(near), Some(next)) => angle_between(near, found) <= 2.0 * angle_between(near, next),
            _ => false,
        }
    })
}

/// Angle between two directions of any length, radians.
fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Root mean square of the angles between horizontal and vertical neighbours, radians for each
/// pixel; `None` where the map shows too little around the pixel.
pub fn pixel_angle(exact: &WarpMap, pixel: DVec2) -> Option<f64> {
    angle_around(exact, pixel, exact.direction(pixel)?)
}

/// As [`pixel_angle`], where the middle shows `direction`.
fn angle_around(exact: &WarpMap, pixel: DVec2, direction: DVec3) -> Option<f64> {
    let span = |axis: DVec2| {
        let middle = (direction, 0.0);
        let end = |offset: f64| exact.direction(pixel + axis * offset).map_or(middle, |direction| (direction, offset));
        let ((a, from), (b, to)) = (end(-0.5), end(0.5));
        (to > from).then(|| angle_between(a, b) / (to - from))
    };
    let (x, y) = (span(DVec2::X)?, span(DVec2::Y)?);
    let size = (0.5 * (x * x + y * y)).sqrt();
    (size > 0.0).then_some(size)
}

/// Returns the distance from a pixel's middle, in output pixels, at which the direction of the
/// exact map differs by `angle` (radians). The angle at a distance is a root mean square over both
/// axes; of each axis the larger of its two sides counts. `None` where a pixel's size is unknown.
/// The result is at most `angle` divided by that size.
///
/// In smooth parts of the map this is the error of [`compare`]. Beside a silhouette it is not,
/// because directions change there with the root of the distance. If a point lies within a ten
/// thousandth of a pixel of the silhouette and is shown that far beside its place, its direction
/// changes by a hundredth of the pixel's angle.
pub fn displacement(exact: &WarpMap, pixel: DVec2, angle: f64) -> Option<f64> {
    let here = exact.direction(pixel)?;
    let most = angle / pixel_angle(exact, pixel)?;
    let turned = |distance: f64| {
        let to = |way: DVec2| exact.direction(pixel + way * distance).map_or(0.0, |seen| angle_between(here, seen));
        let along = |axis: DVec2| to(axis).max(to(-axis));
        along(DVec2::X).hypot(along(DVec2::Y)) * 0.5f64.sqrt()
    };
    // Halves the interval, in exponents, down to a millionth of a millionth of the greatest.
    let (mut low, mut high) = (-40.0f64, 0.0f64);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if turned(most * middle.exp2()) < angle { low = middle } else { high = middle }
    }
    Some(most * high.exp2())
}

#[cfg(test)]
mod tests;
