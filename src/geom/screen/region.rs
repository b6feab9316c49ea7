//! The part of a curved surface that is screen, in angles.

use super::{Rim, inset};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Angles around a surface's centre: from its pole (+y), and around it (0 = front, −z; to the right
/// positive).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Region {
    /// Greatest angle from the pole, radians, 0…π; π = all.
    pub polar: f64,
    /// Range (from, to), radians, `from < to ≤ from + 2π`; `None` = all around.
    pub azimuth: Option<[f64; 2]>,
}

impl Region {
    /// The whole surface.
    pub const ALL: Self = Self { polar: PI, azimuth: None };

    /// True if the direction of `point` from the centre, any length, is in the region. A direction
    /// on a rim is in the region.
    pub fn contains(&self, point: DVec3) -> bool {
        // Compares cosines: near the pole, too, this is as exact as the point.
        let near = self.polar >= PI || point.y >= point.length() * self.polar.cos();
        near && self.azimuth.is_none_or(|range| within(point, range))
    }
}

impl Region {
    /// Unit directions along the region's rims, just within it.
    pub(super) fn rims(&self) -> Vec<Rim<'_>> {
        let towards = |polar: f64, azimuth: f64| {
            DVec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos())
        };
        let (first, last) = self.azimuth.map_or((0.0, TAU), |[from, to]| inset(from, to));
        let (_, lowest) = inset(0.0, self.polar);
        let mut rims: Vec<Rim<'_>> = Vec::new();
        if self.polar < PI {
            rims.push(Box::new(move |part| towards(lowest, first + part * (last - first))));
        }
        if self.azimuth.is_some() {
            rims.extend(
                [first, last].map(|azimuth| -> Rim<'_> { Box::new(move |part| towards(part * lowest, azimuth)) }),
            );
        }
        rims
    }
}

/// True if a point's azimuth is in a range.
pub(super) fn within(point: DVec3, [from, to]: [f64; 2]) -> bool {
    (point.x.atan2(-point.z) - from).rem_euclid(TAU) <= to - from
}

/// Returns the unit direction in which a point at this azimuth moves around the axis, to the right.
pub(super) fn onward(azimuth: f64) -> DVec3 {
    DVec3::new(azimuth.cos(), 0.0, azimuth.sin())
}
