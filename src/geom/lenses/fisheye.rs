//! Projections of fisheye lenses, from angle to radius: the published formulas, polynomials, and
//! measured curves.

use crate::geom::Curve;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A fisheye lens.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct FisheyeLens {
    /// Radius as a function of the angle.
    pub projection: Projection,
    /// Full opening angle, radians. The rim of the circle is at half of it.
    pub aperture: f64,
}

/// Radius in a fisheye's picture as a function of the angle θ from its axis. The scale is free: the
/// rim has radius 1.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum Projection {
    /// θ.
    Equidistant,
    /// sin(θ/2): equal areas.
    Equisolid,
    /// tan(θ/2): equal angles.
    Stereographic,
    /// sin θ.
    Orthographic,
    /// f₁θ + f₃θ³ + f₅θ⁵ + f₇θ⁷, increasing over the whole aperture.
    Polynomial([f64; 4]),
    /// A measured curve of radius over angle, from its first node to its last.
    Measured(Arc<Curve>),
}

/// Number of steps of the search for an angle, enough for bisection alone. Newton's method, which
/// doubles the digits in each step, needs far fewer.
const STEPS: usize = 60;

impl Projection {
    /// Returns the greatest aperture for which the projection has a picture, radians.
    pub fn widest(&self) -> f64 {
        match self {
            Self::Orthographic => PI,
            // At 360° the rim would be infinitely far away.
            Self::Stereographic => TAU * 350.0 / 360.0,
            Self::Measured(curve) => (2.0 * curve.end()).min(TAU),
            _ => TAU,
        }
    }

    /// Returns the radius at an angle, in the projection's own scale, and its derivative.
    fn radius(&self, angle: f64) -> (f64, f64) {
        let half = 0.5 * angle;
        match self {
            Self::Equidistant => (angle, 1.0),
            Self::Equisolid => (half.sin(), 0.5 * half.cos()),
            Self::Stereographic => (half.tan(), 0.5 / (half.cos() * half.cos())),
            Self::Orthographic => (angle.sin(), angle.cos()),
            Self::Measured(curve) => curve.at(angle),
            Self::Polynomial([f1, f3, f5, f7]) => {
                let s = angle * angle;
                let value = angle * (f1 + s * (f3 + s * (f5 + s * f7)));
                (value, f1 + s * (3.0 * f3 + s * (5.0 * f5 + s * 7.0 * f7)))
            }
        }
    }

    /// Returns the angle at a radius in the projection's own scale; `limit` is the greatest angle.
    fn angle(&self, radius: f64, limit: f64) -> f64 {
        match self {
            Self::Equidistant => radius,
            Self::Equisolid => 2.0 * radius.min(1.0).asin(),
            Self::Stereographic => 2.0 * radius.atan(),
            Self::Orthographic => radius.min(1.0).asin(),
            Self::Polynomial(_) | Self::Measured(_) => {
                // Newton's method within a bracket. A step that would leave the bracket halves it
                // instead.
                let (mut low, mut high) = (0.0, limit);
                let mut angle = 0.5 * limit;
                for _ in 0..STEPS {
                    let (value, slope) = self.radius(angle);
                    if value < radius {
                        low = angle
                    } else {
                        high = angle
                    }
                    let next = angle - (value - radius) / slope;
                    let next = if next > low && next < high { next } else { 0.5 * (low + high) };
                    if next == angle {
                        break;
                    }
                    angle = next;
                }
                angle
            }
        }
    }
}

impl FisheyeLens {
    /// True if the radius grows over the whole aperture, so that the lens has an inverse.
    pub fn is_monotone(&self) -> bool {
        const SAMPLES: u32 = 4096;
        let slope = |i: u32| self.projection.radius(0.5 * self.aperture * f64::from(i) / f64::from(SAMPLES)).1;
        (0..SAMPLES).all(|i| slope(i) > 0.0)
    }

    /// Returns the radius at an angle from the axis, radians, in the projection's own scale.
    pub fn radius(&self, angle: f64) -> f64 {
        self.projection.radius(angle).0
    }

    /// Returns the angle from the axis, radians, at a radius (1 = rim).
    pub fn angle(&self, radius: f64) -> f64 {
        let limit = 0.5 * self.aperture;
        self.projection.angle(radius * self.projection.radius(limit).0, limit)
    }

    /// Returns the derivative of the angle at a radius (1 = rim), radians per radius of the circle.
    pub fn slope(&self, radius: f64) -> f64 {
        self.projection.radius(0.5 * self.aperture).0 / self.projection.radius(self.angle(radius)).1
    }

    /// Returns the unit ray of a point of the unit disc; `None` outside the disc and for NaN.
    pub fn direction(&self, point: DVec2) -> Option<DVec3> {
        let radius = point.length();
        if radius.is_nan() || radius > 1.0 {
            return None;
        }
        let (sine, cosine) = self.angle(radius).sin_cos();
        let across = if radius > 0.0 { point * (sine / radius) } else { DVec2::ZERO };
        Some(across.extend(-cosine))
    }

    /// Returns the point of the unit disc that shows a direction of any length; `None` beyond the
    /// aperture. The antipode of the axis gets the rightmost point.
    pub fn point(&self, direction: DVec3) -> Option<DVec2> {
        let across = direction.truncate();
        let angle = across.length().atan2(-direction.z);
        let limit = 0.5 * self.aperture;
        let radius = self.projection.radius(angle).0 / self.projection.radius(limit).0;
        (angle <= limit).then(|| across.try_normalize().unwrap_or(DVec2::X) * radius)
    }
}
