//! Cylinders and cones.

use super::region::within;
use super::{Contour, Hit, Rim, Surface, inset, unit};
use glam::DVec3;
use std::f64::consts::TAU;

/// A part of the wall of a cone or cylinder around the y axis, lit from inside.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Cone {
    /// Height (y) of the bottom and of the top rim, metres; bottom < top.
    pub heights: [f64; 2],
    /// Radius at the bottom and at the top rim, metres, ≥ 0 and not both 0; equal for a cylinder.
    pub radii: [f64; 2],
    /// Range (from, to) around the axis, radians, as [`super::Region::azimuth`].
    pub azimuth: Option<[f64; 2]>,
}

impl Cone {
    /// Slope of the radius over the height.
    pub(super) fn slope(&self) -> f64 {
        (self.radii[1] - self.radii[0]) / (self.heights[1] - self.heights[0])
    }

    fn radius_at(&self, height: f64) -> f64 {
        self.radii[0] + self.slope() * (height - self.heights[0])
    }
}

impl Surface for Cone {
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        self.unbounded_hit(origin, direction).filter(|hit| {
            let [bottom, top] = self.heights;
            let between = hit.point.y >= bottom && hit.point.y <= top;
            between && self.azimuth.is_none_or(|range| within(hit.point, range))
        })
    }

    /// Returns the point at which the ray leaves the cone's inside. With the distance t, `A·t² +
    /// 2B·t + C` is the squared distance from the axis less the squared radius. It increases only
    /// at the root `(−B + √(B² − AC))/A`.
    fn unbounded_hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let direction = unit(direction)?;
        let slope = self.slope();
        // Starts from the ray's point nearest to the middle, so that no large numbers cancel.
        let middle = DVec3::new(0.0, 0.5 * (self.heights[0] + self.heights[1]), 0.0);
        let skipped = (middle - origin).dot(direction);
        let start = origin + direction * skipped;
        let radius = self.radius_at(start.y);
        let a = direction.x * direction.x + direction.z * direction.z - slope * slope * direction.y * direction.y;
        let b = start.x * direction.x + start.z * direction.z - slope * radius * direction.y;
        let c = start.x * start.x + start.z * start.z - radius * radius;
        let discriminant = b * b - a * c;
        if discriminant.is_nan() || discriminant < 0.0 {
            return None;
        }
        let root = discriminant.sqrt();
        // The same root in the form without cancellation.
        let distance = if b <= 0.0 { (root - b) / a } else { -c / (b + root) };
        let point = start + direction * distance;
        let radius = self.radius_at(point.y);
        // Of the two halves of a double cone only the one with a positive radius exists.
        let ahead = distance.is_finite() && distance + skipped > 0.0 && radius >= 0.0;
        let outward = DVec3::new(point.x, -slope * radius, point.z);
        ahead.then(|| Hit { point, normal: -outward.normalize_or(DVec3::Y) })
    }

    fn rims(&self) -> Vec<Rim<'_>> {
        let at = |height: f64, azimuth: f64| {
            let radius = self.radius_at(height);
            DVec3::new(azimuth.sin() * radius, height, -azimuth.cos() * radius)
        };
        let (bottom, top) = inset(self.heights[0], self.heights[1]);
        let (first, last) = self.azimuth.map_or((0.0, TAU), |[from, to]| inset(from, to));
        let circle = |height: f64| -> Rim<'_> { Box::new(move |part| at(height, first + part * (last - first))) };
        let side = |azimuth: f64| -> Rim<'_> { Box::new(move |part| at(bottom + part * (top - bottom), azimuth)) };
        let mut rims = vec![circle(bottom), circle(top)];
        if self.azimuth.is_some() {
            rims.extend([side(first), side(last)]);
        }
        rims
    }

    /// Directions that are steeper than the wall never meet it. Seen from within, the line is 10⁻⁵
    /// radians from the limit of these directions.
    fn horizon(&self) -> Option<Rim<'_>> {
        let slope = self.slope();
        (slope != 0.0).then(|| -> Rim<'_> {
            let height = 1e5 * self.size() * slope.signum();
            let radius = self.radius_at(height);
            Box::new(move |part| {
                let (sine, cosine) = (part * TAU).sin_cos();
                DVec3::new(sine * radius, height, -cosine * radius)
            })
        })
    }

    /// Two straight lines along the wall: at the azimuths where the tangent plane goes through the
    /// point.
    fn contours(&self, from: DVec3) -> Vec<Contour<'_>> {
        let (distance, radius) = (from.x.hypot(from.z), self.radius_at(from.y));
        if distance.is_nan() || radius.abs() >= distance {
            return Vec::new();
        }
        let towards = from.x.atan2(-from.z);
        let aside = (radius / distance).acos();
        let [bottom, top] = self.heights;
        let line = |sign: f64| -> Contour<'_> {
            Box::new(move |part, inset| {
                let height = bottom + part * (top - bottom);
                let (sine, cosine) = (towards + sign * (aside + inset)).sin_cos();
                let radius = self.radius_at(height);
                DVec3::new(sine * radius, height, -cosine * radius)
            })
        };
        vec![line(1.0), line(-1.0)]
    }

    fn size(&self) -> f64 {
        let half_height = 0.5 * (self.heights[1] - self.heights[0]);
        self.radii[0].max(self.radii[1]).max(half_height)
    }
}
