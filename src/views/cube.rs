//! Faces of one turned cube, shared by all outputs that use it.

use super::fit::{Fit, Fitter};
use super::samples::Samples;
use super::single::facing;
use glam::{DMat3, DVec3};
use std::f64::consts::FRAC_PI_4;

/// A face that is sampled.
#[derive(Clone, Debug)]
pub(crate) struct Face {
    /// Viewer axes → face axes.
    pub rotation: DMat3,
    /// The sampled part, and its resolution.
    pub fit: Fit,
    /// Which of the outputs given sample it.
    pub outputs: Vec<usize>,
}

/// The faces of a cube that outputs sample, and what became of the others.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cube {
    /// The faces, those towards the middle of what is seen first.
    pub faces: Vec<Face>,
    /// Centres of the faces that nothing samples, viewer axes.
    pub skipped: Vec<DVec3>,
}

impl Cube {
    /// Texels of all faces.
    pub fn texels(&self) -> f64 {
        self.faces.iter().map(|face| face.fit.texels()).sum()
    }
}

/// The six faces of a cube as axes (local → cube): front, right, left, up, down, back.
fn face_axes() -> [DMat3; 6] {
    [DVec3::NEG_Z, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z].map(facing)
}

/// The cubes that are tried (cube → viewer axes): for each of `frames` aligned with it, an edge
/// forward (upright, lying, and rolled by 45°), and both corners forward.
pub(crate) fn candidates(frames: &[DMat3]) -> Vec<DMat3> {
    // The angle between a face's centre and the diagonal of an edge-forward cube.
    let corner = (1.0 / 2f64.sqrt()).atan();
    let turns = [
        DMat3::IDENTITY,
        DMat3::from_rotation_y(FRAC_PI_4),
        DMat3::from_rotation_x(FRAC_PI_4),
        DMat3::from_rotation_z(FRAC_PI_4),
        DMat3::from_rotation_x(corner) * DMat3::from_rotation_y(FRAC_PI_4),
        DMat3::from_rotation_x(-corner) * DMat3::from_rotation_y(FRAC_PI_4),
    ];
    frames.iter().flat_map(|frame| turns.map(|turn| *frame * turn)).collect()
}

/// What the outputs sample of the cube `turned` (cube → viewer axes).
///
/// `pixel` is the size of the finest pixel in radians. A face counts as sampled only if something
/// is seen more than a fifth of a pixel inside it: less is shown by the margin of its neighbour,
/// and a dome that ends exactly at an edge of the cube (180° and a cube with a corner or an edge
/// forward) must not make faces beyond the edge.
pub(crate) fn sampled(turned: DMat3, outputs: &[&Samples], quality: f64, pixel: f64, fine: bool) -> Cube {
    let ignored = (0.2 * pixel).clamp(1e-9, 0.02);
    let mut cube = Cube::default();
    for axes in face_axes() {
        let axes = turned * axes;
        let rotation = axes.transpose();
        let mut fitter = Fitter::new(rotation);
        let mut users = Vec::new();
        for (index, samples) in outputs.iter().enumerate() {
            let mut core = Fitter::new(rotation);
            core.add_within(samples, 1.0 - ignored);
            if !core.is_empty() {
                users.push(index);
                fitter.add_within(samples, 1.0 + 2.0 * ignored);
            }
        }
        match fitter.fit(quality, fine) {
            Some(fit) => cube.faces.push(Face { rotation, fit, outputs: users }),
            None => cube.skipped.push(-axes.z_axis),
        }
    }
    cube
}

/// The cube that costs least: texels of its faces, and `face_cost` for each face. `levels` are the
/// outputs' samples, from the coarsest to the finest; each level but the last picks two cubes for the next.
pub(crate) fn best(frames: &[DMat3], levels: &[Vec<&Samples>], quality: f64, pixel: f64, face_cost: f64) -> Cube {
    let mut turned = candidates(frames);
    let mut found = Cube::default();
    for (level, outputs) in levels.iter().enumerate() {
        let last = level + 1 == levels.len();
        let cost = |cube: &Cube| cube.texels() + face_cost * cube.faces.len() as f64;
        let mut ranked: Vec<(Cube, DMat3)> =
            turned.iter().map(|&turn| (sampled(turn, outputs, quality, pixel, last), turn)).collect();
        // Stable, and costs are compared to a thousandth: of equals, the first candidate wins,
        // whatever the rounding.
        ranked.sort_by_key(|(cube, _)| (cost(cube).ln() * 1e3).round() as i64);
        turned = ranked.iter().take(2).map(|(_, turn)| *turn).collect();
        if let Some((cube, _)) = ranked.into_iter().next() {
            found = cube;
        }
    }
    found
}
