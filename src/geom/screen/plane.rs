//! Flat screens.

use super::{Hit, INSET, Rim, Surface, unit};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// A rectangle in the plane z = 0 around the origin, lit from either side (front or rear
/// projection).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Plane {
    /// Width and height, metres, > 0.
    pub size: DVec2,
}

impl Surface for Plane {
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        self.unbounded_hit(origin, direction).filter(|hit| (2.0 * hit.point.truncate()).abs().cmple(self.size).all())
    }

    fn unbounded_hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let direction = unit(direction)?;
        let distance = -origin.z / direction.z;
        let point = (origin + direction * distance).with_z(0.0);
        let ahead = distance > 0.0 && distance.is_finite() && point.is_finite();
        ahead.then(|| Hit { point, normal: DVec3::new(0.0, 0.0, origin.z.signum()) })
    }

    fn rims(&self) -> Vec<Rim<'_>> {
        let half = 0.5 * self.size * (1.0 - INSET);
        let side =
            |from: DVec2, to: DVec2| -> Rim<'_> { Box::new(move |part| (from.lerp(to, part) * half).extend(0.0)) };
        let corners = [DVec2::NEG_ONE, DVec2::new(1.0, -1.0), DVec2::ONE, DVec2::new(-1.0, 1.0)];
        (0..4).map(|i| side(corners[i], corners[(i + 1) % 4])).collect()
    }

    /// Directions along the plane or away from it never meet it. Seen from near the screen, the
    /// line is about 10⁻⁵ radians from the limit of these directions.
    fn horizon(&self) -> Option<Rim<'_>> {
        let radius = 1e5 * self.size();
        Some(Box::new(move |part| (DVec2::from_angle(part * TAU) * radius).extend(0.0)))
    }

    fn size(&self) -> f64 {
        0.5 * self.size.max_element()
    }
}
