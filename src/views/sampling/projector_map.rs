//! Map of a projector without a screen of its own: rays from a point to the dome.

use crate::views::sampling::sample::{Sample, of_unit_length, outer};
use glam::{DMat3, DVec2, DVec3};

/// Map of a projector. Everything is in dome axes, except `to_viewer`.
#[derive(Clone, Debug)]
pub(super) struct ProjectorMap {
    pub(super) origin: DVec3,
    pub(super) rays: DMat3,
    /// The inverse of `rays`.
    pub(super) picture: DMat3,
    pub(super) radius: f64,
    pub(super) pole: DVec3,
    /// Least cosine of the angle from the pole; `None` = the whole sphere is screen.
    pub(super) least_cosine: Option<f64>,
    pub(super) eye: DVec3,
    pub(super) to_viewer: DMat3,
}

/// Point where a projector's ray meets the dome.
pub(super) struct Hit {
    pub(super) point: DVec3,
    pub(super) ray: DVec3,
    /// Distance to the point, in lengths of the ray.
    pub(super) distance: f64,
}

impl Hit {
    /// Returns the motion of the point on the dome when the ray changes by `change`.
    fn moved_by(&self, change: DVec3) -> DVec3 {
        // The point stays on the sphere: its motion is across its own radius.
        (change - self.ray * (self.point.dot(change) / self.point.dot(self.ray))) * self.distance
    }
}

impl ProjectorMap {
    /// Returns the sample of a hit; `per_pixel` is the size of a pixel in picture coordinates.
    pub(super) fn sample(&self, hit: &Hit, per_pixel: DVec2) -> Option<Sample> {
        let across = self.to_viewer * hit.moved_by(self.rays.x_axis * per_pixel.x);
        let down = self.to_viewer * hit.moved_by(self.rays.y_axis * per_pixel.y);
        of_unit_length(self.to_viewer * (hit.point - self.eye), outer(across, across) + outer(down, down))
    }

    /// Returns the far intersection of the ray with the sphere, if it lies ahead and on the screen.
    pub(super) fn hit(&self, at: DVec2) -> Option<Hit> {
        let ray = self.rays * at.extend(1.0);
        let squared = ray.length_squared();
        let along = ray.dot(self.origin) / squared;
        let foot = self.origin - ray * along;
        let rest = self.radius * self.radius - foot.length_squared();
        if rest < 0.0 {
            return None;
        }
        let distance = (rest / squared).sqrt() - along;
        let point = self.origin + ray * distance;
        let on_screen = self.least_cosine.is_none_or(|least| point.dot(self.pole) >= least * self.radius);
        (distance > 0.0 && on_screen).then_some(Hit { point, ray, distance })
    }
}
