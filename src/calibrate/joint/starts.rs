//! Guesses of the camera from which the fit starts, and the best of the fits.

use super::{Joint, Observation};
use crate::calibrate::camera::{self, Camera, CameraLens};
use crate::calibrate::least_squares::{self, Fit, Model};
use glam::{DVec2, DVec3};

/// Number of starts, for each kind of lens, from which all projectors are fitted.
const BEST: usize = 2;
/// Largest usual distance of a camera from the screen's middle, as a part of the screen's size.
const USUAL: f64 = 0.8;
/// Focal lengths that are tried, as parts of the photograph's width.
const FISHEYE: [f64; 6] = [0.12, 0.17, 0.24, 0.34, 0.48, 0.68];
const PINHOLE: [f64; 5] = [0.35, 0.5, 0.8, 1.3, 2.2];

/// Best of the fits from several guesses of the camera.
pub(super) fn best<'a>(whole: &Joint<'a>, aimed_by_first: bool) -> Option<(Joint<'a>, Fit)> {
    let thin = whole.thinned();
    let held = vec![true; thin.first(thin.projectors.len())];
    let mut starts: Vec<(f64, Camera)> = guesses(&thin)
        .into_iter()
        .map(|camera| {
            let model = Joint { camera, held: held.clone(), ..thin.clone() };
            let fit = least_squares::roughly(&model, vec![0.0; model.parameters()]);
            (fit.cost, model.state(&fit.parameters).1)
        })
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut held = Vec::new();
    if aimed_by_first {
        // In a projector's pose the rotation follows the position.
        held = [[false; 3], [true; 3]].concat();
    }
    // From the wall behind it, a sphere is seen under half the angles. It looks nearly as from the
    // middle with half the focal length, so both are tried.
    let is_inside =
        |camera: &Camera| camera.pose.position.distance(whole.screen.pose.position) < USUAL * whole.screen.size();
    let of = |lens: CameraLens, inside: bool, count: usize| {
        let own = move |(_, camera): &&(f64, Camera)| camera.lens == lens && is_inside(camera) == inside;
        starts.iter().filter(own).take(count)
    };
    let fisheyes = of(CameraLens::Fisheye, true, BEST).chain(of(CameraLens::Fisheye, false, 1));
    let pinholes = of(CameraLens::Pinhole, true, BEST).chain(of(CameraLens::Pinhole, false, 1));
    let fitted = |(_, camera): &(f64, Camera)| {
        let model = Joint { camera: camera.clone(), held: held.clone(), ..thin.clone() };
        let fit = least_squares::robust(&model, vec![0.0; model.parameters()]);
        (fit.cost, model.moved(&fit.parameters))
    };
    let less = |a: &(f64, Joint), b: &(f64, Joint)| a.0.total_cmp(&b.0);
    let mut best = fisheyes.chain(pinholes).map(fitted).min_by(less)?;
    if !is_inside(&best.1.camera) {
        // A place on the wall is taken only after all others were tried.
        best = starts.iter().map(fitted).chain([best]).min_by(less)?;
    }
    let best = best.1;
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
