//! Cameras in calibration files.

use crate::geom::Frustum;
use glam::{DMat3, DVec2, DVec3};

/// A camera to whose flat picture the positions of a calibration refer; axes x right, y up, z
/// backward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position relative to the eye point, in the file's units.
    pub offset: DVec3,
    /// Rotation from the camera's axes to those of the file.
    pub rotation: DMat3,
    /// Opening of the camera.
    pub frustum: Frustum,
}

impl Camera {
    /// Ray of a place in the picture (parts of width and height from the bottom left). It is not of
    /// unit length, so that rays between two places lie on a line.
    pub fn ray(&self, place: DVec2) -> DVec3 {
        let frustum = &self.frustum;
        let (x, y) = (frustum.left + place.x * frustum.width(), frustum.bottom + place.y * frustum.height());
        self.rotation * DVec3::new(x, y, -1.0)
    }

    /// Place of a direction in the picture, perhaps outside of 0…1; `None` behind the camera.
    pub fn place(&self, direction: DVec3) -> Option<DVec2> {
        let local = self.rotation.transpose() * direction;
        let (x, y) = (local.x / -local.z, local.y / -local.z);
        let frustum = &self.frustum;
        (local.z < 0.0)
            .then(|| DVec2::new((x - frustum.left) / frustum.width(), (y - frustum.bottom) / frustum.height()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::pose;

    #[test]
    fn places_and_rays_are_inverse() {
        let frustum = Frustum { left: -1.0, right: 0.5, bottom: -0.25, top: 0.75 };
        let camera = Camera { offset: DVec3::ZERO, rotation: pose::rotation(0.4, -0.2, 0.1), frustum };
        for place in [DVec2::ZERO, DVec2::ONE, DVec2::new(0.3, 1.4)] {
            assert!(camera.place(camera.ray(place) * 3.0).unwrap().distance(place) < 1e-12);
            assert_eq!(camera.place(-camera.ray(place)), None);
        }
        assert!(camera.ray(DVec2::new(2.0 / 3.0, 0.25)).distance(camera.rotation * DVec3::NEG_Z) < 1e-12);
    }
}
