//! Solves all projectors at once, from photographs of one camera whose place and lens are not
//! known.
//!
//! Each observation is a place of a projector's picture and the place of the photograph in which it
//! was seen. Between them lies the screen, whose shape is known. The residual is the place where
//! the camera would see what the projector lights there, minus the place where it was seen.
//!
//! Angles and distances from the dome's centre are relative. A rotation of everything about the
//! centre of a sphere changes no photograph: marks fix it, or the aim of the first output. A factor
//! on all lengths changes none either: the radius of the rig fixes it.

mod starts;

use super::camera::{Camera, CameraLens};
use super::least_squares::{self, Fit, Model};
use super::marks::{self, Mark, Solved};
use super::{Part, Projector, Symmetric};
use crate::error::{Error, ErrorKind, Result};
use crate::geom::{Optics, Pose, Screen};
use crate::rig::Rig;
use glam::{DVec2, DVec3};

/// A place of an output's picture that was seen by the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Number of the output.
    pub output: usize,
    /// The place in its picture, pixels from the top left.
    pub pixel: DVec2,
    /// The place in the photograph, pixels from the top left.
    pub seen: DVec2,
}

/// Observations of a dome.
#[derive(Clone, Debug, Default)]
pub struct Observed {
    /// Width and height of the photographs, pixels.
    pub photograph: (u32, u32),
    /// Places that were seen.
    pub sightings: Vec<Sighting>,
    /// Places in the photograph of known direction from the dome's centre (unit length, dome axes).
    pub landmarks: Vec<(DVec2, DVec3)>,
    /// Marks of outputs.
    pub marks: Vec<Mark>,
}

/// How far a mark is from where the result has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted {
    /// Distance, pixels of the photograph or of the output that it belongs to; ∞ if the result has
    /// no place for it.
    pub distance: f64,
    /// True if it had an influence on the result.
    pub used: bool,
}

/// Result of [`solve`].
#[derive(Clone, Debug)]
pub struct Found {
    /// The outputs that were seen, by their numbers.
    pub outputs: Vec<(usize, Solved)>,
    /// The camera.
    pub camera: Camera,
    /// The landmarks, in their order.
    pub landmarks: Vec<Fitted>,
    /// The marks of outputs, in their order; `None` for those of outputs that were not seen.
    pub marks: Vec<Option<Fitted>>,
    /// Root mean square of the used residuals in the photograph, pixels.
    pub rms: f64,
    /// True if the dome's rotation follows from the aim of the first output, because there were no
    /// marks.
    pub aimed_by_first: bool,
}

/// Fewest sightings of an output.
const FEWEST: usize = 20;
/// Number of an output's sightings that are used to find a start.
const FOR_START: usize = 25;
/// Fewest marks and landmarks that fix the rotation.
const FIX: usize = 2;

/// Solves all outputs that were seen; `sizes` are the sizes of all pictures of the rig, `parts` are
/// free.
///
/// # Errors
/// [`ErrorKind::InvalidArgument`] if an output is no projector with such parts, or the observations
/// do not determine it.
pub fn solve(rig: &Rig, sizes: &[(u32, u32)], observed: &Observed, parts: &[Part]) -> Result<Found> {
    let invalid = |why: String| Error::new(ErrorKind::InvalidArgument, why);
    let count = |output: usize| observed.sightings.iter().filter(|sighting| sighting.output == output).count();
    let screen = rig.surface();
    let seen = seen(rig, observed);
    if seen.is_empty() {
        return Err(invalid("no output was seen".into()));
    }
    if let Some(output) = seen.iter().find(|output| count(**output) < FEWEST) {
        let (name, count) = (&rig.outputs[*output].name, count(*output));
        return Err(invalid(format!("output \"{name}\" was seen in {count} places; it needs {FEWEST} at least")));
    }
    let camera = first_camera(&screen, observed.photograph);
    let whole = Joint::new(rig, &screen, sizes, observed, camera, parts)?;
    let aimed_by_first = observed.landmarks.len() + observed.marks.len() < FIX;
    let (model, fit) = starts::best(&whole, aimed_by_first)
        .ok_or_else(|| invalid("what was seen does not fit the rig: is it roughly right?".into()))?;
    let mut found = found(&model, &fit, &seen, aimed_by_first)?;
    // Landmarks and marks come in the order in which they were given, after all sightings.
    let fitted =
        |at: usize| Fitted { distance: fit.residuals[at].map_or(f64::INFINITY, DVec2::length), used: fit.used[at] };
    let (all, fitted) = (&model, &fitted);
    let of_kind = |group| (0..all.all.len()).filter(move |at| all.group(*at) == group).map(fitted);
    found.landmarks = of_kind(1).collect();
    let mut marks = of_kind(2);
    let mark = |mark: &Mark| if seen.contains(&mark.output) { marks.next() } else { None };
    found.marks = observed.marks.iter().map(mark).collect();
    Ok(found)
}

/// Least errors that any way to solve the outputs can have with such photographs (Cramér, Rao), in
/// the order of the outputs that were seen: root mean squares over their pictures, pixels. `None`
/// if the outputs are not determined.
///
/// `rig`, `camera` and `observed` are exact; `deviations` are the standard deviations of the errors
/// that each coordinate of sightings, landmarks and marks will have, pixels.
///
/// # Errors
/// As [`solve`].
pub fn limits(
    rig: &Rig,
    sizes: &[(u32, u32)],
    observed: &Observed,
    camera: &Camera,
    parts: &[Part],
    deviations: [f64; GROUPS],
) -> Result<Option<Vec<f64>>> {
    let screen = rig.surface();
    let model = Joint::new(rig, &screen, sizes, observed, camera.clone(), parts)?;
    let exact = vec![0.0; model.parameters()];
    let used = vec![true; model.observations()];
    let information = least_squares::information(&model, &exact, &used, &deviations);
    let limit = |covariance: &Symmetric, (index, projector): (usize, &Projector)| {
        let own = model.first(index)..model.first(index + 1);
        marks::expected(projector, &exact[own.clone()], &covariance.part(own), &screen)
    };
    let limits = |covariance| model.projectors.iter().enumerate().map(|own| limit(&covariance, own)).collect();
    Ok(information.inverse().map(limits))
}

/// Numbers of the outputs that were seen.
fn seen(rig: &Rig, observed: &Observed) -> Vec<usize> {
    let is_seen = |output: &usize| observed.sightings.iter().any(|sighting| sighting.output == *output);
    (0..rig.outputs.len()).filter(is_seen).collect()
}

/// Camera from which all guesses start.
fn first_camera(screen: &Screen, size: (u32, u32)) -> Camera {
    let pose = Pose { position: screen.pose.position, rotation: glam::DMat3::IDENTITY };
    Camera::new(pose, CameraLens::Fisheye, f64::from(size.0), size)
}

/// Number of kinds of observations.
const GROUPS: usize = 3;

/// One observation; `projector` is an index into the outputs that were seen.
#[derive(Clone, Copy, Debug)]
enum Observation {
    Seen { projector: usize, pixel: DVec2, seen: DVec2 },
    Landmark { seen: DVec2, point: DVec3 },
    Mark { projector: usize, pixel: DVec2, point: DVec3 },
}

fn observations(screen: &Screen, outputs: &[usize], observed: &Observed) -> Option<Vec<Observation>> {
    let place = |output: usize| outputs.iter().position(|own| *own == output);
    let point = |direction: DVec3| Some(screen.unbounded_hit(DVec3::ZERO, direction)?.point);
    let seen = observed.sightings.iter().filter_map(|sighting| {
        let projector = place(sighting.output)?;
        Some(Observation::Seen { projector, pixel: sighting.pixel, seen: sighting.seen })
    });
    let mut all: Vec<Observation> = seen.collect();
    for (seen, direction) in &observed.landmarks {
        all.push(Observation::Landmark { seen: *seen, point: point(*direction)? });
    }
    for mark in &observed.marks {
        // Marks of outputs that were not seen say nothing about the others.
        let Some(projector) = place(mark.output) else { continue };
        all.push(Observation::Mark { projector, pixel: mark.pixel, point: point(mark.direction)? });
    }
    Some(all)
}

/// Camera and projectors as one problem of least squares.
#[derive(Clone)]
struct Joint<'a> {
    screen: &'a Screen,
    camera: Camera,
    projectors: Vec<Projector>,
    all: Vec<Observation>,
    /// True for each parameter that is held; parameters beyond its end are free.
    held: Vec<bool>,
}

impl<'a> Joint<'a> {
    /// Takes the outputs that were seen as they are in the rig.
    fn new(
        rig: &Rig,
        screen: &'a Screen,
        sizes: &[(u32, u32)],
        observed: &Observed,
        camera: Camera,
        parts: &[Part],
    ) -> Result<Self> {
        let seen = seen(rig, observed);
        let projector = |output: &usize| Projector::new(&rig.outputs[*output], sizes[*output], parts, screen.size());
        let projectors = seen.iter().map(projector).collect::<Result<_>>()?;
        let all = observations(screen, &seen, observed)
            .ok_or_else(|| Error::new(ErrorKind::InvalidArgument, "a mark is in a direction where no screen is"))?;
        Ok(Self { screen, camera, projectors, all, held: Vec::new() })
    }

    /// Index of a projector's first parameter. For the number of projectors, that of the camera's
    /// first one.
    fn first(&self, projector: usize) -> usize {
        self.projectors[..projector].iter().map(Projector::parameters).sum()
    }

    /// The same problem, starting from the result of a fit.
    fn moved(&self, fit: &[f64]) -> Self {
        let mut moved = self.clone();
        let state = self.state(fit);
        for (projector, optics) in moved.projectors.iter_mut().zip(state.0) {
            *projector = projector.with(optics, projector.parts());
        }
        moved.camera = state.1;
        moved
    }

    /// The same problem with fewer sightings.
    fn thinned(&self) -> Self {
        let mut left = vec![0usize; self.projectors.len()];
        let mut every = vec![0usize; self.projectors.len()];
        for observation in &self.all {
            if let Observation::Seen { projector, .. } = observation {
                every[*projector] += 1;
            }
        }
        let mut keep = |observation: &Observation| match observation {
            Observation::Seen { projector, .. } => {
                left[*projector] += 1;
                left[*projector].is_multiple_of((every[*projector] / FOR_START).max(1))
            }
            _ => true,
        };
        Self { all: self.all.iter().copied().filter(|observation| keep(observation)).collect(), ..self.clone() }
    }
}

impl Model for Joint<'_> {
    type State = (Vec<Optics>, Camera);

    fn parameters(&self) -> usize {
        self.first(self.projectors.len()) + self.camera.parameters()
    }

    fn observations(&self) -> usize {
        self.all.len()
    }

    fn state(&self, parameters: &[f64]) -> Self::State {
        let mut rest = parameters;
        let mut optics = Vec::with_capacity(self.projectors.len());
        for projector in &self.projectors {
            let (own, after) = rest.split_at(projector.parameters().min(rest.len()));
            optics.push(projector.optics(own));
            rest = after;
        }
        (optics, self.camera.moved(rest, self.screen.size()))
    }

    fn residual(&self, (optics, camera): &Self::State, observation: usize) -> Option<DVec2> {
        match self.all[observation] {
            Observation::Seen { projector, pixel, seen } => {
                let (origin, direction) = self.projectors[projector].ray(&optics[projector], pixel)?;
                Some(camera.place(self.screen.unbounded_hit(origin, direction)?.point)? - seen)
            }
            Observation::Landmark { seen, point } => Some(camera.place(point)? - seen),
            Observation::Mark { projector, pixel, point } => {
                Some(self.projectors[projector].pixel(&optics[projector], point)? - pixel)
            }
        }
    }

    fn depends(&self, observation: usize) -> impl Iterator<Item = usize> {
        let own = |projector: usize| {
            let first = self.first(projector);
            first..first + self.projectors[projector].parameters()
        };
        let camera = self.first(self.projectors.len())..self.parameters();
        let (projector, camera) = match self.all[observation] {
            Observation::Seen { projector, .. } => (own(projector), camera),
            Observation::Landmark { .. } => (0..0, camera),
            Observation::Mark { projector, .. } => (own(projector), 0..0),
        };
        projector.chain(camera).filter(|index| !self.is_held(*index))
    }

    /// Clicked places are less precise than decoded ones.
    fn group(&self, observation: usize) -> usize {
        match self.all[observation] {
            Observation::Seen { .. } => 0,
            Observation::Landmark { .. } => 1,
            Observation::Mark { .. } => 2,
        }
    }

    fn groups(&self) -> usize {
        GROUPS
    }

    /// A projector may be far from its place when all others fit.
    fn set(&self, observation: usize) -> usize {
        match self.all[observation] {
            Observation::Seen { projector, .. } | Observation::Mark { projector, .. } => projector,
            Observation::Landmark { .. } => 0,
        }
    }

    fn sets(&self) -> usize {
        self.projectors.len()
    }

    fn is_held(&self, parameter: usize) -> bool {
        self.held.get(parameter).copied().unwrap_or(false)
    }
}

/// Result of a fit for all outputs.
fn found(model: &Joint, fit: &Fit, outputs: &[usize], aimed_by_first: bool) -> Result<Found> {
    let (optics, camera) = model.state(&fit.parameters);
    let mut solved = Vec::new();
    for (index, output) in outputs.iter().enumerate() {
        let own: Vec<usize> = (0..model.all.len())
            .filter(|at| match model.all[*at] {
                Observation::Seen { projector, .. } | Observation::Mark { projector, .. } => projector == index,
                Observation::Landmark { .. } => false,
            })
            .collect();
        let angle = |at: usize| {
            let Observation::Seen { pixel: from, .. } = model.all[at] else { return None };
            let (origin, direction) = model.projectors[index].ray(&optics[index], from)?;
            let point = model.screen.unbounded_hit(origin, direction)?.point;
            // Angles are small: they are proportional to the steps on the screen.
            let step = 1e-4 * point.length() * point.any_orthonormal_vector();
            let pixels = camera.place(point + step)?.distance(camera.place(point)?);
            Some(1e-4 * fit.residuals[at]?.length() / pixels.max(f64::MIN_POSITIVE))
        };
        let projector = &model.projectors[index];
        let quality = marks::quality(projector, fit, model.first(index), model.screen, &own, angle);
        let quality = quality.ok_or_else(|| {
            let why = "what was seen does not determine the projectors; let the camera see more of each";
            Error::new(ErrorKind::InvalidArgument, why)
        })?;
        solved.push((*output, Solved { optics: optics[index].clone(), quality }));
    }
    let used = fit.residuals.iter().zip(&fit.used).filter(|(_, used)| **used);
    let rms = marks::rms(used.filter_map(|(residual, _)| residual.map(DVec2::length)));
    Ok(Found { outputs: solved, camera, landmarks: Vec::new(), marks: Vec::new(), rms, aimed_by_first })
}

#[cfg(test)]
mod tests;
