//! The dome as a sphere.

use glam::DVec3;

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Sphere {
    /// Centre, metres.
    pub center: DVec3,
    /// Radius, metres, > 0.
    pub radius: f64,
}

impl Sphere {
    /// Returns the point at which the ray from `origin` along `direction` (any length but 0) leaves
    /// the sphere. From inside this is the only hit, from outside the far one. Returns `None` if
    /// the ray misses, if the sphere lies behind it, or if the direction is zero or not finite.
    ///
    /// The foot of the perpendicular from the centre is computed from `o × d`, not from the
    /// difference of large squares (Haines, Günther, Akenine-Möller, *Ray Tracing Gems* ch. 7), so
    /// the error relative to the radius is about 1e-16 times (1 + distance of the origin / radius).
    pub fn far_hit(&self, origin: DVec3, direction: DVec3) -> Option<DVec3> {
        self.hit(origin, direction, 1.0)
    }

    /// Returns the point at which the ray enters the sphere. From inside the result is `None`,
    /// since the ray never enters. Accuracy and other cases are as for [`Self::far_hit`].
    pub fn near_hit(&self, origin: DVec3, direction: DVec3) -> Option<DVec3> {
        if origin.distance_squared(self.center) <= self.radius * self.radius {
            return None;
        }
        self.hit(origin, direction, -1.0)
    }

    /// True if `point` is inside or on the sphere.
    pub fn contains(&self, point: DVec3) -> bool {
        point.distance_squared(self.center) <= self.radius * self.radius
    }

    /// Returns the hit on one side of the foot point. `sign`: 1 = far, −1 = near.
    fn hit(&self, origin: DVec3, direction: DVec3, sign: f64) -> Option<DVec3> {
        let scale = direction.abs().max_element();
        if !(scale > 0.0 && scale.is_finite()) {
            return None;
        }
        // Scaled first, so that lengths neither overflow nor underflow.
        let unit = (direction / scale).normalize();
        let from_center = origin - self.center;
        if from_center.length_squared() > self.radius * self.radius && from_center.dot(unit) >= 0.0 {
            return None;
        }
        let foot = unit.cross(from_center.cross(unit));
        let half_chord_squared = self.radius * self.radius - foot.length_squared();
        if half_chord_squared.is_nan() || half_chord_squared < 0.0 {
            return None;
        }
        Some(self.center + foot + unit * (sign * half_chord_squared.sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;

    #[test]
    fn hits_lie_on_the_sphere_and_on_the_ray() {
        let mut random = Random::new(1);
        for _ in 0..20_000 {
            let sphere = Sphere { center: random.vector(-5.0, 5.0), radius: random.range(0.1, 20.0) };
            let origin = sphere.center + random.direction() * sphere.radius * random.range(0.0, 0.9999);
            let direction = random.direction() * 10f64.powf(random.range(-150.0, 150.0));
            let hit = sphere.far_hit(origin, direction).expect("from inside every ray hits");
            let path = (hit - origin).normalize();
            assert!((hit.distance(sphere.center) / sphere.radius - 1.0).abs() < 1e-13);
            assert!(path.cross(direction.normalize_or(path)).length() < 1e-9 && path.dot(direction) > 0.0);
            assert_eq!(sphere.near_hit(origin, direction), None);
        }
    }

    #[test]
    fn from_far_away_the_hit_is_the_far_one_and_exact() {
        // A hit is chosen first, then the ray through it, so that the expected result is known.
        let mut random = Random::new(2);
        let sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };
        for distance in [2.0, 1e2, 1e4, 1e6] {
            for _ in 0..2_000 {
                let origin = random.direction() * distance;
                let target = random.direction();
                let path = target - origin;
                // If positive, the target is on the far side, behind the silhouette as seen from
                // the origin. Grazing rays are left out.
                let steep = target.dot(path.normalize());
                if steep.abs() < 0.05 {
                    continue;
                }
                let hit = if steep > 0.0 { sphere.far_hit(origin, path) } else { sphere.near_hit(origin, path) };
                let error = hit.expect("the ray goes through a point of the sphere").distance(target);
                assert!(error < 1e-14 * distance / steep.abs() + 1e-14, "{distance} {error}");
            }
        }
    }

    #[test]
    fn misses_and_degenerate_rays_hit_nothing() {
        let sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };
        let outside = DVec3::new(0.0, 0.0, 3.0);
        assert_eq!(sphere.far_hit(outside, DVec3::Z), None, "the sphere is behind");
        assert_eq!(sphere.far_hit(outside, DVec3::new(1.0, 0.0, -1.0)), None, "past the silhouette");
        for bad in [DVec3::ZERO, DVec3::new(f64::NAN, 0.0, 0.0), DVec3::new(f64::INFINITY, 0.0, 0.0)] {
            assert_eq!(sphere.far_hit(DVec3::ZERO, bad), None);
        }
        assert_eq!(sphere.far_hit(DVec3::NAN, DVec3::X), None);
    }
}
