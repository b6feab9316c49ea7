//! The rig to be found, a technician's rough description of it, and the camera.

use crate::failure::Failure;
use crate::random::Random;
use cupola::calibrate::{Camera, CameraLens, Part, Projector, marks};
use cupola::geom::{Optics, Pose};
use cupola::rig::{self, OutputKind, Rig};
use glam::{DVec2, DVec3};

/// Preset whose dome has many projectors.
pub const PRESET: &str = "planetarium-6";
/// A projector's pose and the numbers of its lens.
pub const LENS: [Part; 4] = [Part::Pose, Part::Fov, Part::Shift, Part::Radial];
/// Size of the pictures of all outputs.
pub const SIZE: (u32, u32) = (1920, 1080);
/// Size of a photograph: 12 megapixels.
pub const PHOTOGRAPH: (u32, u32) = (4000, 3000);

/// A rig with its rough description.
pub struct World {
    /// Exact rig.
    pub exact: Rig,
    /// Rig from which calibration starts.
    pub rough: Rig,
}

impl World {
    /// Makes a preset's dome with projectors moved by centimetres and degrees. If the numbers of
    /// the lenses or of a mirror are free as well, they are those of real ones.
    pub fn new(preset: &str, parts: &[Part], random: &mut Random) -> Result<Self, Failure> {
        let exact = rig::load(preset)?;
        let mut world = Self { rough: exact.clone(), exact };
        for output in 0..world.exact.outputs.len() {
            let described = &world.exact.outputs[output];
            let projector = Projector::new(described, SIZE, parts, world.exact.surface().size())?;
            let rest: &[f64] = match parts.contains(&Part::Mirror) {
                true => &[0.006, -0.004, 0.008, 0.005],
                false => &[0.01, -0.008, 0.02, 0.01, -0.05, 0.02],
            };
            let pose = random.vector(-0.02, 0.02).to_array().into_iter().chain(random.vector(-0.05, 0.05).to_array());
            let optics =
                projector.optics(&pose.chain(rest.iter().copied()).take(projector.parameters()).collect::<Vec<f64>>());
            world.exact.outputs[output].kind = OutputKind::Optics { optics: Box::new(optics), even_light: 0.0 };
        }
        Ok(world)
    }

    /// Exact projector of an output.
    pub fn projector(&self, output: usize) -> Result<(Projector, Optics), Failure> {
        let projector = Projector::new(&self.exact.outputs[output], SIZE, &[Part::Pose], self.exact.surface().size())?;
        let optics = projector.optics(&[]);
        Ok((projector, optics))
    }

    /// Error of the result for an output: root mean square over its picture, pixels.
    pub fn error(&self, output: usize, found: &Optics) -> Result<f64, Failure> {
        let (projector, right) = self.projector(output)?;
        Ok(marks::difference(&projector, &right, found, &self.exact.surface()))
    }

    /// A random place of an output's picture, with the point of the screen that it lights.
    pub fn lit(&self, projector: &Projector, optics: &Optics, random: &mut Random) -> (DVec2, DVec3) {
        let screen = self.exact.surface();
        loop {
            let size = (f64::from(SIZE.0), f64::from(SIZE.1));
            let pixel = DVec2::new(random.range(0.0, size.0), random.range(0.0, size.1));
            let hit = projector.ray(optics, pixel).and_then(|(origin, direction)| screen.hit(origin, direction));
            if let Some(hit) = hit {
                return (pixel, hit.point);
            }
        }
    }
}

/// A camera near the dome's centre with a fisheye that looks at the middle of the screen: up, or
/// ahead if the dome is tilted to the front.
pub fn camera(world: &World, random: &mut Random) -> Camera {
    let ahead = world.exact.dome.tilt > 0.25 * std::f64::consts::PI;
    let angles = if ahead { [0.1, 0.05, 0.2] } else { [0.4, 1.2, 0.3] };
    let reach = 0.12 * world.exact.surface().size();
    let pose = Pose::new(random.vector(-reach, reach), angles[0], angles[1], angles[2]);
    let mut camera = Camera::new(pose, CameraLens::Fisheye, 905.0, PHOTOGRAPH);
    camera.radial = [-0.03, 0.002, 0.0];
    camera.center += DVec2::new(31.0, -18.0);
    camera
}

/// True if a place is in the photograph.
pub fn is_inside(place: DVec2) -> bool {
    let size = DVec2::new(f64::from(PHOTOGRAPH.0), f64::from(PHOTOGRAPH.1));
    place.cmpge(DVec2::ZERO).all() && place.cmple(size).all()
}

/// Places in the photograph of points of the dome with known directions.
pub fn landmarks(world: &World, camera: &Camera, count: usize, random: &mut Random) -> Vec<(DVec2, DVec3)> {
    let mut found = Vec::with_capacity(count);
    while found.len() < count {
        let direction = random.direction();
        let point = world.exact.surface().hit(DVec3::ZERO, direction).map(|hit| hit.point);
        if let Some(seen) = point.and_then(|point| camera.place(point)).filter(|place| is_inside(*place)) {
            found.push((seen, direction));
        }
    }
    found
}
