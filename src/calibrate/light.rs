//! Finds the brightness of projectors from photographs of grey pictures: their response, their
//! black, and their light all over their pictures.
//!
//! The camera gathers from a place the light of the place times the camera's own falloff towards
//! its rim. The light of a place is a projector's brightness, times the falloff of its lens,
//! divided by the area that its pixel lights there. Areas follow from the geometry, which is known
//! by then. The logarithms of the rest are linear in the unknowns. Both falloffs are even
//! polynomials of the distance from an axis; they can be separated because the axes differ.
//!
//! The paint of the screen is assumed to be matt and equally bright everywhere.

use super::least_squares::median;
use super::{Camera, Projector, Symmetric};
use crate::blend::EdgeWeight;
use crate::error::{Error, ErrorKind, Result};
use crate::geom::{Optics, Screen};
use crate::rig::Rig;
use glam::{DVec2, DVec3};

/// Grey pictures that are photographed: values of 8 bits from black to white.
pub const LEVELS: [u8; 16] = [0, 17, 34, 51, 68, 85, 102, 119, 136, 153, 170, 187, 204, 221, 238, 255];

/// Light of a place of an output, as the camera gathered it.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Number of the output.
    pub output: usize,
    /// The place in its picture, pixels from the top left.
    pub pixel: DVec2,
    /// The place in the photograph, pixels from the top left.
    pub seen: DVec2,
    /// Light for each of [`LEVELS`], in any unit that is the same for all readings.
    pub light: [f64; LEVELS.len()],
}

/// Result for one output.
#[derive(Clone, Debug, PartialEq)]
pub struct Lit {
    /// Number of the output.
    pub output: usize,
    /// Light of values, both 0…1 and growing, from black to white.
    pub response: Vec<[f64; 2]>,
    /// Light of white divided by that of black; `None` where black is too dark to be measured.
    pub contrast: Option<f64>,
    /// Logarithm of the brightness in the middle of the lens for an area of 1 m², and the
    /// coefficients of its falloff.
    brightness: [f64; FALLOFF + 1],
}

/// Result of [`solve`].
#[derive(Clone, Debug)]
pub struct Found {
    /// Results of the outputs that were seen.
    pub outputs: Vec<Lit>,
    /// Root mean square difference between readings of white and the result, as a part of the
    /// light.
    pub rms: f64,
    /// Light that all places can have: that of the darkest place, in the readings' unit.
    even: f64,
    /// The light of the brightest place, as a multiple of that of the darkest.
    pub range: f64,
    screen: Screen,
    outlines: Vec<(Projector, Optics)>,
    /// Rule for the raw weight of each output where outputs overlap; `None` for an output that is
    /// not blended.
    edges: Vec<Option<EdgeWeight>>,
}

/// Coefficients of a projector's falloff: of sin²θ and sin⁴θ, θ being the angle from the axis.
const FALLOFF: usize = 2;
/// Coefficients of the camera's falloff: of r², r⁴ and r⁶, r in half heights of the photograph.
const CAMERA: usize = 3;
/// Fewest readings of an output.
const FEWEST: usize = 20;
/// Readings are left out if their distance is more than this number of median distances.
const FAR: f64 = 5.0;
/// Least step of the light from one grey picture to the next, as a part of white, that is no noise.
const LEAST_STEP: f64 = 2e-5;
/// Greatest contrast that is distinguished from a black without any light.
const GREATEST_CONTRAST: f64 = 1e6;

/// Solves the light of all outputs that were read. `rig` and `camera` are calibrated; `sizes` are
/// the sizes of all pictures of the rig.
///
/// # Errors
/// [`ErrorKind::InvalidArgument`] if an output is no projector, or its readings do not determine
/// its light.
pub fn solve(rig: &Rig, sizes: &[(u32, u32)], camera: &Camera, readings: &[Reading]) -> Result<Found> {
    let invalid = |why: String| Error::new(ErrorKind::InvalidArgument, why);
    let count = |output: usize| readings.iter().filter(|reading| reading.output == output).count();
    let outputs: Vec<usize> = (0..rig.outputs.len()).filter(|output| count(*output) > 0).collect();
    if let Some(output) = outputs.iter().find(|output| count(**output) < FEWEST) {
        let (name, count) = (&rig.outputs[*output].name, count(*output));
        return Err(invalid(format!("the light of output \"{name}\" was seen in {count} places; {FEWEST} are needed")));
    }
    let screen = rig.surface();
    let projector = |output: &usize| {
        let projector = Projector::new(&rig.outputs[*output], sizes[*output], &[], screen.size())?;
        let optics = projector.optics(&[]);
        Ok((projector, optics))
    };
    let outlines: Vec<(Projector, Optics)> = outputs.iter().map(projector).collect::<Result<_>>()?;
    let model = Model { screen: &screen, outlines: &outlines, camera };
    let places: Vec<(usize, &Reading)> = readings
        .iter()
        .filter_map(|reading| Some((outputs.iter().position(|own| *own == reading.output)?, reading)))
        .collect();
    let (white, rms) = model.white(&places).ok_or_else(|| {
        invalid(
            "the photographs do not tell how bright the projectors are: is white brighter than black in them?".into(),
        )
    })?;
    let contrasts = model.contrasts(&places, &white);
    let mut lit = Vec::new();
    for (index, output) in outputs.iter().enumerate() {
        let own: Vec<&Reading> = places.iter().filter(|(at, _)| *at == index).map(|(_, reading)| *reading).collect();
        let name = &rig.outputs[*output].name;
        let response = response(&own).ok_or_else(|| {
            invalid(format!("output \"{name}\": its grey pictures do not become brighter in the photographs"))
        })?;
        let contrast = contrasts.get(index).copied().filter(|contrast| *contrast < GREATEST_CONTRAST);
        lit.push(Lit { output: *output, response, contrast, brightness: model.own(&white, index) });
    }
    let edge = |output: &usize| {
        let blend = &rig.outputs[*output].blend;
        blend.overlap.then(|| EdgeWeight::of(blend))
    };
    let edges = outputs.iter().map(edge).collect();
    let mut found = Found { outputs: lit, rms, even: 0.0, range: 1.0, screen, outlines, edges };
    let light: Vec<f64> = places.iter().filter_map(|(index, reading)| found.light(*index, reading.pixel)).collect();
    let (least, most) =
        light.iter().fold((f64::MAX, 0.0f64), |(least, most), light| (least.min(*light), most.max(*light)));
    (found.even, found.range) = (least, most / least);
    Ok(found)
}

impl Found {
    /// Light of white at a pixel of an output: the sum over all projectors with their blend weights
    /// there. `None` where the pixel lights nothing. `index` counts the outputs that were seen.
    fn light(&self, index: usize, pixel: DVec2) -> Option<f64> {
        let (projector, optics) = &self.outlines[index];
        let (origin, direction) = projector.ray(optics, pixel)?;
        let point = self.screen.unbounded_hit(origin, direction)?.point;
        let mut shared = [0.0, 0.0];
        let mut alone = 0.0;
        for ((lit, (projector, optics)), edge) in self.outputs.iter().zip(&self.outlines).zip(&self.edges) {
            let Some(place) = projector.pixel(optics, point).filter(|place| projector.shows(*place)) else { continue };
            let Some(light) = light(&lit.brightness, projector, optics, &self.screen, place) else { continue };
            match edge {
                Some(edge) => {
                    let size = projector.size();
                    // In its corner the raw weight of a picture is 0; where it is the only one, it
                    // has all the weight nevertheless.
                    let asked = edge.raw_weight(place / DVec2::new(f64::from(size.0), f64::from(size.1))).max(1e-9);
                    shared[0] += asked * light;
                    shared[1] += asked;
                }
                None => alone += light,
            }
        }
        let light = alone + if shared[1] > 0.0 { shared[0] / shared[1] } else { 0.0 };
        (light > 0.0).then_some(light)
    }

    /// Factor 0…1 that dims a pixel of an output so that the light of all projectors is that of the
    /// darkest place. `index` counts the outputs that were seen.
    pub fn dimming(&self, index: usize, pixel: DVec2) -> f64 {
        self.light(index, pixel).map_or(1.0, |light| (self.even / light).min(1.0))
    }
}

fn light(
    brightness: &[f64; FALLOFF + 1],
    projector: &Projector,
    optics: &Optics,
    screen: &Screen,
    pixel: DVec2,
) -> Option<f64> {
    let area = area(projector, optics, screen, pixel)?;
    let sine = projector.off_axis(optics, pixel)?.sin().powi(2);
    Some((brightness[0] + brightness[1] * sine + brightness[2] * sine * sine).exp() / area)
}

/// Area of the screen that a pixel lights, square metres. The screen's outline does not count.
fn area(projector: &Projector, optics: &Optics, screen: &Screen, pixel: DVec2) -> Option<f64> {
    let point = |place: DVec2| {
        let (origin, direction) = projector.ray(optics, place)?;
        Some(screen.unbounded_hit(origin, direction)?.point)
    };
    let step = |axis: DVec2| Some(point(pixel + 0.5 * axis)? - point(pixel - 0.5 * axis)?);
    let area = step(DVec2::X)?.cross(step(DVec2::Y)?).length();
    (area > 0.0).then_some(area)
}

/// Data that is known before the light is solved.
struct Model<'a> {
    screen: &'a Screen,
    outlines: &'a [(Projector, Optics)],
    camera: &'a Camera,
}

impl Model<'_> {
    fn parameters(&self) -> usize {
        self.outlines.len() * (FALLOFF + 1) + CAMERA
    }

    fn own(&self, parameters: &[f64], index: usize) -> [f64; FALLOFF + 1] {
        std::array::from_fn(|at| parameters[index * (FALLOFF + 1) + at])
    }

    /// Powers of the distance from the camera's axis.
    fn camera_terms(&self, seen: DVec2) -> [f64; CAMERA] {
        let square = (seen - self.camera.center).length_squared() / (0.5 * f64::from(self.camera.size.1)).powi(2);
        [square, square * square, square * square * square]
    }

    /// Part of the light of a place that the camera gathers.
    fn gathered(&self, parameters: &[f64], seen: DVec2) -> f64 {
        let own = &parameters[self.parameters() - CAMERA..];
        self.camera_terms(seen).iter().zip(own).map(|(term, own)| term * own).sum::<f64>().exp()
    }

    /// Logarithm of a reading of white with its derivatives: parameter and value. `None` for a
    /// reading that says nothing.
    fn row(&self, (index, reading): &(usize, &Reading)) -> Option<(f64, Vec<(usize, f64)>)> {
        let (projector, optics) = &self.outlines[*index];
        let white = reading.light[LEVELS.len() - 1] - reading.light[0];
        let area = area(projector, optics, self.screen, reading.pixel)?;
        let sine = projector.off_axis(optics, reading.pixel)?.sin().powi(2);
        let first = index * (FALLOFF + 1);
        let own = [1.0, sine, sine * sine].into_iter().enumerate().map(|(at, term)| (first + at, term));
        let last = self.parameters() - CAMERA;
        let camera = self.camera_terms(reading.seen).into_iter().enumerate().map(|(at, term)| (last + at, term));
        (white > 0.0).then(|| ((white * area).ln(), own.chain(camera).collect()))
    }

    /// Parameters for white, and the root mean square of the differences that were used.
    fn white(&self, places: &[(usize, &Reading)]) -> Option<(Vec<f64>, f64)> {
        let rows: Vec<(f64, Vec<(usize, f64)>)> = places.iter().filter_map(|place| self.row(place)).collect();
        let mut far = f64::INFINITY;
        let mut solved = vec![0.0; self.parameters()];
        let rest = |solved: &[f64], (value, terms): &(f64, Vec<(usize, f64)>)| {
            value - terms.iter().map(|(at, term)| term * solved[*at]).sum::<f64>()
        };
        // The first round uses all readings.
        for round in 0..4 {
            let used = rows.iter().filter(|row| round == 0 || rest(&solved, row).abs() <= far);
            solved = linear(self.parameters(), used)?;
            let mut distances: Vec<f64> = rows.iter().map(|row| rest(&solved, row).abs()).collect();
            far = (FAR * median(&mut distances)).max(1e-12);
        }
        let used: Vec<f64> = rows.iter().map(|row| rest(&solved, row)).filter(|rest| rest.abs() <= far).collect();
        Some((solved, super::marks::rms(used.into_iter())))
    }

    /// Light of white divided by that of black, for each projector. Black photographs show the sum
    /// of the blacks of all projectors and the light of the room; the overlaps separate them.
    fn contrasts(&self, places: &[(usize, &Reading)], white: &[f64]) -> Vec<f64> {
        let room = self.outlines.len();
        let row = |(index, reading): &(usize, &Reading)| {
            let point = self.point(*index, reading.pixel)?;
            let mut terms = vec![(room, 1.0)];
            for (other, (projector, optics)) in self.outlines.iter().enumerate() {
                let place = projector.pixel(optics, point).filter(|place| projector.shows(*place));
                let own = place.and_then(|place| light(&self.own(white, other), projector, optics, self.screen, place));
                terms.extend(own.map(|own| (other, own)));
            }
            Some((reading.light[0] / self.gathered(white, reading.seen), terms))
        };
        let rows: Vec<(f64, Vec<(usize, f64)>)> = places.iter().filter_map(row).collect();
        let blacks = linear(room + 1, rows.iter()).unwrap_or_default();
        // White contains the light of black as well.
        blacks.iter().take(room).map(|black| 1.0 + 1.0 / black.max(f64::MIN_POSITIVE)).collect()
    }

    fn point(&self, index: usize, pixel: DVec2) -> Option<DVec3> {
        let (projector, optics) = &self.outlines[index];
        let (origin, direction) = projector.ray(optics, pixel)?;
        Some(self.screen.unbounded_hit(origin, direction)?.point)
    }
}

/// Least-squares solution of rows, each with a value and its terms.
fn linear<'a>(parameters: usize, rows: impl Iterator<Item = &'a (f64, Vec<(usize, f64)>)>) -> Option<Vec<f64>> {
    let mut matrix = Symmetric::zero(parameters);
    let mut right = vec![0.0; parameters];
    for (value, terms) in rows {
        for (place, (i, by_i)) in terms.iter().enumerate() {
            right[*i] += by_i * value;
            terms[..=place].iter().for_each(|(j, by_j)| matrix.add(*i, *j, by_i * by_j));
        }
    }
    matrix.solve(&right)
}

/// Response of an output: the median over its readings, so that no single place decides.
fn response(readings: &[&Reading]) -> Option<Vec<[f64; 2]>> {
    let mut points = vec![[0.0, 0.0]];
    for (level, value) in LEVELS.iter().enumerate().skip(1) {
        let part = |reading: &&Reading| {
            let black = reading.light[0];
            (reading.light[level] - black) / (reading.light[LEVELS.len() - 1] - black)
        };
        let light = median(&mut readings.iter().map(part).filter(|part| part.is_finite()).collect::<Vec<_>>());
        // Near black, noise may be greater than the light.
        if light > points[points.len() - 1][1] + LEAST_STEP {
            points.push([f64::from(*value) / 255.0, light]);
        }
    }
    (points.len() > LEVELS.len() / 2 && points[points.len() - 1] == [1.0, 1.0]).then_some(points)
}

#[cfg(test)]
mod tests;
