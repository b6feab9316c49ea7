//! Surfaces of the second degree around the origin.

use super::Sphere;
use glam::DVec3;

/// Surface of the points with `Σ weights·p² = level`. It is lit from inside, where the sum is less
/// than `level`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Quadric {
    /// Weights of x², y², z². All are ≥ 0, but that of y² is < 0 for a double cone.
    pub weights: DVec3,
    /// The sum on the surface, ≥ 0; 0 for a double cone.
    pub level: f64,
    /// Sign of y on the half of a double cone that exists; 0 for other surfaces.
    pub half: f64,
}

impl Quadric {
    /// An ellipsoid with these half axes, > 0. For a sphere the weights are exactly 1.
    pub fn ellipsoid(radii: DVec3) -> Self {
        let greatest = radii.max_element();
        let ratios = greatest / radii;
        Self { weights: ratios * ratios, level: greatest * greatest, half: 0.0 }
    }

    /// A cylinder around the y axis.
    pub fn cylinder(radius: f64) -> Self {
        Self { weights: DVec3::new(1.0, 0.0, 1.0), level: radius * radius, half: 0.0 }
    }

    /// A cone around the y axis with its apex at the origin. The radius is the height times `slope`
    /// ≠ 0.
    pub fn cone(slope: f64) -> Self {
        Self { weights: DVec3::new(1.0, -slope * slope, 1.0), level: 0.0, half: slope.signum() }
    }

    /// The weighted product of two vectors.
    pub fn product(&self, a: DVec3, b: DVec3) -> f64 {
        (self.weights * a).dot(b)
    }

    /// Returns the difference between the surface's sum and the sum at a point: > 0 inside.
    pub fn depth(&self, point: DVec3) -> f64 {
        self.level - self.product(point, point)
    }

    /// True if a point is inside, at most at the fraction `part` of the way from the centre or the
    /// axis to the surface.
    pub fn contains(&self, point: DVec3, part: f64) -> bool {
        let squares = self.weights * point * point;
        let (outward, inward) = (squares.max(DVec3::ZERO).element_sum(), squares.min(DVec3::ZERO).element_sum());
        outward <= part * part * (self.level - inward) && self.half * point.y >= 0.0
    }

    /// True if a line leaves the inside at one point at most; false for double cones.
    pub fn is_convex(&self) -> bool {
        self.weights.min_element() >= 0.0
    }
}

impl From<&Sphere> for Quadric {
    /// The sphere around the origin with the same radius.
    fn from(sphere: &Sphere) -> Self {
        Self { weights: DVec3::ONE, level: sphere.radius * sphere.radius, half: 0.0 }
    }
}
