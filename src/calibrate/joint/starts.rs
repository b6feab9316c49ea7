//! Guesses of the camera from which the fit starts, and the best of the fits.

use super::{Joint, Observation};
use crate::calibrate::camera::{self, Camera, CameraLens};
use crate::calibrate::least_squares::{self, Fit, Model};
use glam::{DVec2, DVec3};

/// Cameras whose focal lengths differ by less, as a part of them, lead to the same fit.
const SAME: f64 = 0.02;
/// Focal lengths that are tried, as parts of the photograph's width.
const FISHEYE: [f64; 6] = [0.12, 0.17, 0.24, 0.34, 0.48, 0.68];
const PINHOLE: [f64; 5] = [0.35, 0.5, 0.8, 1.3, 2.2];

/// Best of the fits from several guesses of the camera.
pub(super) fn best<'a>(whole: &Joint<'a>, aimed_by_first: bool) -> Option<(Joint<'a>, Fit)> {
    let thin = whole.thinned();
    let held = vec![true; thin.first(thin.projectors.len())];
    let guesses = guesses(&thin);
    let placed = guesses.iter().map(|camera| {
        let model = Joint { camera: camera.clone(), held: held.clone(), ..thin.clone() };
        let fit = least_squares::roughly(&model, vec![0.0; model.parameters()]);
        model.state(&fit.parameters).1
    });
    let mut cameras: Vec<Camera> = Vec::new();
    for camera in placed {
        let same = |other: &Camera| other.lens == camera.lens && (other.focal / camera.focal - 1.0).abs() < SAME;
        if !cameras.iter().any(same) {
            cameras.push(camera);
        }
    }
    // A rough rig pulls the camera away from its place, and its focal length with it. So the guesses
    // themselves are tried as well. They are in the middle; cameras near the wall need the others.
    cameras.extend(guesses);
    let mut held = Vec::new();
    if aimed_by_first {
        // In a projector's pose the rotation follows the position.
        held = [[false; 3], [true; 3]].concat();
    }
    let fitted = |camera: Camera| {
        let model = Joint { camera, held: held.clone(), ..thin.clone() };
        let fit = least_squares::robust(&model, vec![0.0; model.parameters()]);
        (fit.cost, model.moved(&fit.parameters))
    };
    let (_, best) = cameras.into_iter().map(fitted).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let model = Joint { all: whole.all.clone(), ..best };
    let fit = least_squares::robust(&model, vec![0.0; model.parameters()]);
    Some((model, fit))
}

/// Cameras in the dome's centre with lenses of all kinds, turned so that they see each thing about
/// where the rig has it.
fn guesses(model: &Joint) -> Vec<Camera> {
    let (optics, _) = model.state(&[]);
    let points: Vec<(DVec2, DVec3)> = model
        .all
        .iter()
        .filter_map(|observation| match *observation {
            Observation::Seen { projector, pixel, seen } => {
                let (origin, direction) = model.projectors[projector].ray(&optics[projector], pixel)?;
                Some((seen, model.screen.unbounded_hit(origin, direction)?.point))
            }
            Observation::Landmark { seen, point } => Some((seen, point)),
            Observation::Mark { .. } => None,
        })
        .collect();
    let lenses = FISHEYE.map(|focal| (CameraLens::Fisheye, focal)).into_iter();
    let lenses = lenses.chain(PINHOLE.map(|focal| (CameraLens::Pinhole, focal)));
    let guess = |(lens, focal): (CameraLens, f64)| {
        let size = model.camera.size;
        let mut camera = Camera::new(model.camera.pose, lens, focal * f64::from(size.0), size);
        let pair = |(seen, point): &(DVec2, DVec3)| {
            Some((camera.ideal_ray(*seen)?, (*point - camera.pose.position).try_normalize()?))
        };
        let pairs: Vec<(DVec3, DVec3)> = points.iter().filter_map(pair).collect();
        camera.pose.rotation = camera::rotation(&pairs);
        camera
    };
    lenses.map(guess).collect()
}
