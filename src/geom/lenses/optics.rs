//! A projector with any lens, optionally in front of a convex spherical mirror.

use crate::geom::{Lens, Pose, Sphere};
use glam::{DVec2, DVec3};

/// Optics of a projector: its lens, and optionally a mirror.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Optics {
    /// Position and orientation of the lens, in dome axes.
    pub pose: Pose,
    /// The lens.
    pub lens: Lens,
    /// Sphere whose outside reflects the light. Rays that miss it light nothing.
    pub mirror: Option<Sphere>,
}

/// Number of halvings of an angle, down to the rounding of f64.
const HALVINGS: usize = 60;

impl Optics {
    /// Returns the start and the direction (any length) of the ray from the projector to the screen
    /// for a point of the picture (−1…1 both ways; its width is `aspect` times its height). `None`
    /// if the lens has no ray or the ray misses the mirror.
    pub fn ray(&self, picture: DVec2, aspect: f64) -> Option<(DVec3, DVec3)> {
        let direction = self.pose.direction_to_parent(self.lens.ray(picture, aspect)?);
        let Some(mirror) = self.mirror else { return Some((self.pose.position, direction)) };
        let point = mirror.near_hit(self.pose.position, direction)?;
        let normal = (point - mirror.center) / mirror.radius;
        Some((point, direction - normal * (2.0 * direction.dot(normal))))
    }

    /// Returns the position in the picture (possibly outside −1…1) of a point in space: the inverse
    /// of following [`Self::ray`]. `None` if no light goes there.
    pub fn picture(&self, point: DVec3, aspect: f64) -> Option<DVec2> {
        let aim = match &self.mirror {
            Some(mirror) => self.reflection(mirror, point)?,
            None => point,
        };
        self.lens.picture(self.pose.direction_to_local(aim - self.pose.position), aspect)
    }

    /// Returns the point of the mirror that reflects light to `point` (Alhazen's problem).
    ///
    /// It lies in the plane of lens, mirror centre and point, at an angle φ from the lens. The
    /// angle of incidence grows and the angle of reflection falls with φ, so halving finds where
    /// they are equal.
    fn reflection(&self, mirror: &Sphere, point: DVec3) -> Option<DVec3> {
        let (lens, target) = (self.pose.position - mirror.center, point - mirror.center);
        let (a, b) = (lens.length() / mirror.radius, target.length() / mirror.radius);
        if !(a > 1.0 && b > 1.0) {
            return None;
        }
        let axis = lens / (a * mirror.radius);
        let opening = lens.cross(target).length().atan2(lens.dot(target));
        let across = (target - axis * axis.dot(target)).try_normalize().unwrap_or(axis.any_orthonormal_vector());
        let slant = |distance: f64, angle: f64| (distance * angle.sin()).atan2(distance * angle.cos() - 1.0);
        let (mut low, mut high) = (0.0, opening);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if slant(a, middle) < slant(b, opening - middle) { low = middle } else { high = middle }
        }
        let angle = 0.5 * (low + high);
        // Behind the mirror's outline there is no reflection.
        let lit = slant(a, angle) < std::f64::consts::FRAC_PI_2;
        lit.then(|| mirror.center + (axis * angle.cos() + across * angle.sin()) * mirror.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Frustum;
    use crate::testing::random::Random;

    fn before(mirror: Sphere) -> Optics {
        let frustum = Frustum { left: -0.5, right: 0.5, bottom: -0.35, top: 0.35 };
        let pose = Pose::new(DVec3::new(0.1, -0.4, -1.5), 3.1, 0.05, 0.02);
        Optics { pose, lens: Lens::pinhole(frustum), mirror: Some(mirror) }
    }

    #[test]
    fn reflection_is_undone_and_obeys_its_law() {
        let mirror = Sphere { center: DVec3::new(0.0, -0.5, -0.4), radius: 0.3 };
        let optics = before(mirror);
        let dome = Sphere { center: DVec3::ZERO, radius: 3.0 };
        let mut random = Random::new(21);
        let mut seen = 0;
        for _ in 0..20_000 {
            let picture = DVec2::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0));
            let Some((point, direction)) = optics.ray(picture, 1.5) else { continue };
            let normal = (point - mirror.center).normalize();
            let incoming = (point - optics.pose.position).normalize();
            let outgoing = direction.normalize();
            assert!((incoming.dot(normal) + outgoing.dot(normal)).abs() < 1e-13, "equal angles");
            assert!(incoming.cross(outgoing).dot(normal).abs() < 1e-13, "in one plane");
            let Some(hit) = dome.far_hit(point, direction) else { panic!("inside the dome") };
            // Grazing light is ill-conditioned: the error is the square root of rounding.
            if outgoing.dot(normal) > 0.02 {
                let back = optics.picture(hit, 1.5).expect("lit");
                assert!(back.distance(picture) < 1e-10, "{picture} {back}");
                seen += 1;
            }
        }
        assert!(seen > 2_000, "{seen}");
    }

    #[test]
    fn straight_back_and_nowhere() {
        let mirror = Sphere { center: DVec3::new(0.0, 0.0, -2.0), radius: 0.5 };
        let optics = Optics { pose: Pose::new(DVec3::ZERO, 0.0, 0.0, 0.0), ..before(mirror) };
        let (point, direction) = optics.ray(DVec2::ZERO, 1.0).expect("the axis meets the mirror");
        assert!(point.distance(DVec3::new(0.0, 0.0, -1.5)) < 1e-15 && direction.normalize().distance(DVec3::Z) < 1e-15);
        assert_eq!(optics.ray(DVec2::new(0.9, 0.0), 1.0), None, "past the mirror");
        assert_eq!(optics.picture(DVec3::new(0.0, 0.0, -2.1), 1.0), None, "inside the mirror");
    }
}
