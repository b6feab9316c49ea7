//! Spheres and ellipsoids.

use super::{Contour, Hit, Region, Rim, Surface};
use crate::geom::Sphere;
use glam::DVec3;
use std::f64::consts::TAU;

/// A part of an ellipsoid around the origin, lit from inside. A ray lights its far hit, also from
/// outside: the light comes in through the near wall.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Ellipsoid {
    /// Half axes along x, y, z, metres, > 0.
    pub radii: DVec3,
    /// The part that is screen.
    pub region: Region,
}

impl Surface for Ellipsoid {
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        self.unbounded_hit(origin, direction).filter(|hit| self.region.contains(hit.point))
    }

    fn unbounded_hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        // Division by the half axes turns the ellipsoid into the unit sphere; a line stays a line.
        let unit = Sphere { center: DVec3::ZERO, radius: 1.0 };
        let on_unit = unit.far_hit(origin / self.radii, direction / self.radii)?;
        Some(Hit { point: on_unit * self.radii, normal: -(on_unit / self.radii).normalize() })
    }

    fn rims(&self) -> Vec<Rim<'_>> {
        let mut rims: Vec<Rim<'_>> = Vec::new();
        for direction in self.region.rims() {
            rims.push(Box::new(move |part| {
                let towards = direction(part);
                towards / (towards / self.radii).length()
            }));
        }
        rims
    }

    /// On the unit sphere the contour is a circle around the direction of the point.
    fn contours(&self, from: DVec3) -> Vec<Contour<'_>> {
        let from = from / self.radii;
        let distance = from.length();
        if distance.is_nan() || distance <= 1.0 {
            return Vec::new();
        }
        let axis = from / distance;
        let (first, second) = axis.any_orthonormal_pair();
        vec![Box::new(move |part, inset| {
            let (sine, cosine) = (part * TAU).sin_cos();
            let towards = 1.0 / distance - inset;
            let across = (1.0 - towards * towards).max(0.0).sqrt();
            (axis * towards + (first * cosine + second * sine) * across) * self.radii
        })]
    }

    fn size(&self) -> f64 {
        self.radii.max_element()
    }
}
