//! Lenses that are no ideal pinhole: fisheyes of every common projection, and Brown–Conrady distortion.
//!
//! Pictures are measured in −1…1 from left to right and from bottom to top, rays in lens axes (x right, y up, −z
//! ahead). Both directions are f64; where one of them has no closed form it is iterated to rounding, and a
//! point at which the iteration does not arrive has no ray.

use super::Frustum;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// A lens of a projector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// A pinhole, perhaps distorted.
    Pinhole {
        /// The opening of the picture as it is projected, tangents.
        frustum: Frustum,
        /// What the lens does to tangents.
        distortion: Distortion,
    },
    /// A fisheye whose circle is inscribed in the picture.
    Fisheye(FisheyeLens),
}

/// Radial and tangential distortion of a pinhole's tangents after Brown (1966) and Conrady (1919):
/// `(x, y)·(1 + k₁r² + k₂r⁴ + k₃r⁶) + (2p₁xy + p₂(r² + 2x²), p₁(r² + 2y²) + 2p₂xy)` is where the ray `(x, y, −1)` appears.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distortion {
    /// k₁, k₂, k₃.
    pub radial: [f64; 3],
    /// p₁, p₂.
    pub tangential: [f64; 2],
}

/// A fisheye lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FisheyeLens {
    /// How the radius grows with the angle.
    pub projection: Projection,
    /// Whole opening angle, radians; the circle's rim lies at half of it.
    pub aperture: f64,
}

/// How the radius of a fisheye's picture grows with the angle θ from its axis (scale apart: the rim has radius 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// θ.
    Equidistant,
    /// sin(θ/2): equal areas.
    Equisolid,
    /// tan(θ/2): equal angles.
    Stereographic,
    /// sin θ.
    Orthographic,
    /// f₁θ + f₃θ³ + f₅θ⁵ + f₇θ⁷, growing over the whole aperture.
    Polynomial([f64; 4]),
}

/// Steps of an iteration that doubles its digits, with room to spare.
const NEWTON_STEPS: usize = 30;
/// Where an undistorted tangent is taken as found: the distance of its image from the point asked for.
const ARRIVED: f64 = 1e-13;

impl Distortion {
    /// No distortion.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Where the ray `(x, y, −1)` appears, and the derivative by x and by y.
    pub fn apply(&self, tangent: DVec2) -> (DVec2, [DVec2; 2]) {
        let ([k1, k2, k3], [p1, p2]) = (self.radial, self.tangential);
        let DVec2 { x, y } = tangent;
        let r2 = tangent.length_squared();
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
        let bent = DVec2::new(2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y);
        let mixed = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
        let by_x = DVec2::new(radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x, mixed);
        let by_y = DVec2::new(mixed, radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x);
        (tangent * radial + bent, [by_x, by_y])
    }

    /// The tangent whose image is `image`, to 1e-13; `None` where Newton's method does not arrive, or
    /// arrives where the picture is folded over (the derivative's determinant is not positive).
    pub fn undo(&self, image: DVec2) -> Option<DVec2> {
        let allowed = ARRIVED * image.abs().max_element().max(1.0);
        let mut tangent = image;
        for _ in 0..NEWTON_STEPS {
            let (found, [by_x, by_y]) = self.apply(tangent);
            let determinant = by_x.perp_dot(by_y);
            if determinant.is_nan() || determinant <= 0.0 {
                return None;
            }
            let miss = image - found;
            if miss.length() <= allowed {
                return Some(tangent);
            }
            tangent += DVec2::new(miss.perp_dot(by_y), by_x.perp_dot(miss)) / determinant;
        }
        None
    }
}

impl Projection {
    /// The greatest aperture that the projection has a picture for, radians.
    pub fn widest(&self) -> f64 {
        match self {
            Self::Orthographic => PI,
            // At 360° the rim would be infinitely far away.
            Self::Stereographic => TAU * 350.0 / 360.0,
            _ => TAU,
        }
    }

    /// The radius at an angle, in the projection's own scale, and its derivative.
    fn radius(&self, angle: f64) -> (f64, f64) {
        let half = 0.5 * angle;
        match self {
            Self::Equidistant => (angle, 1.0),
            Self::Equisolid => (half.sin(), 0.5 * half.cos()),
            Self::Stereographic => (half.tan(), 0.5 / (half.cos() * half.cos())),
            Self::Orthographic => (angle.sin(), angle.cos()),
            Self::Polynomial([f1, f3, f5, f7]) => {
                let s = angle * angle;
                let value = angle * (f1 + s * (f3 + s * (f5 + s * f7)));
                (value, f1 + s * (3.0 * f3 + s * (5.0 * f5 + s * 7.0 * f7)))
            }
        }
    }

    /// The angle at a radius in the projection's own scale; `limit` is the greatest angle.
    fn angle(&self, radius: f64, limit: f64) -> f64 {
        match self {
            Self::Equidistant => radius,
            Self::Equisolid => 2.0 * radius.min(1.0).asin(),
            Self::Stereographic => 2.0 * radius.atan(),
            Self::Orthographic => radius.min(1.0).asin(),
            Self::Polynomial(_) => {
                // Newton's method within a bracket that halves where it would leave it.
                let (mut low, mut high) = (0.0, limit);
                let mut angle = 0.5 * limit;
                for _ in 0..2 * NEWTON_STEPS {
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
    /// Whether the radius grows over the whole aperture, so that the lens has an inverse.
    pub fn is_monotone(&self) -> bool {
        const SAMPLES: u32 = 4096;
        let slope = |i: u32| self.projection.radius(0.5 * self.aperture * f64::from(i) / f64::from(SAMPLES)).1;
        (0..SAMPLES).all(|i| slope(i) > 0.0)
    }

    /// The unit ray at a point of the unit disc; `None` outside of it and for NaN.
    pub fn direction(&self, point: DVec2) -> Option<DVec3> {
        let radius = point.length();
        if radius.is_nan() || radius > 1.0 {
            return None;
        }
        let limit = 0.5 * self.aperture;
        let angle = self.projection.angle(radius * self.projection.radius(limit).0, limit);
        let (sine, cosine) = angle.sin_cos();
        let across = if radius > 0.0 { point * (sine / radius) } else { DVec2::ZERO };
        Some(across.extend(-cosine))
    }

    /// The point of the unit disc that shows a direction of any length; `None` beyond the aperture. The
    /// antipode of the axis is put on the right.
    pub fn point(&self, direction: DVec3) -> Option<DVec2> {
        let across = direction.truncate();
        let angle = across.length().atan2(-direction.z);
        let limit = 0.5 * self.aperture;
        let radius = self.projection.radius(angle).0 / self.projection.radius(limit).0;
        (angle <= limit).then(|| across.try_normalize().unwrap_or(DVec2::X) * radius)
    }
}

impl Lens {
    /// The ray (any length) of a point of a picture whose width is `aspect` times its height; `None` where there is none.
    pub fn ray(&self, picture: DVec2, aspect: f64) -> Option<DVec3> {
        match self {
            Self::Pinhole { frustum, distortion } => {
                let ray = frustum.rays() * picture.extend(1.0);
                if distortion.is_none() { Some(ray) } else { Some(distortion.undo(ray.truncate())?.extend(-1.0)) }
            }
            Self::Fisheye(lens) => lens.direction(picture * circle_scale(aspect)),
        }
    }

    /// Where a ray of any length appears: the inverse of [`Self::ray`]; perhaps outside −1…1.
    pub fn picture(&self, ray: DVec3, aspect: f64) -> Option<DVec2> {
        match self {
            Self::Pinhole { frustum, distortion } => {
                let tangent = ray.truncate() / -ray.z;
                let image = distortion.apply(tangent).0;
                // Beyond the fold of the distortion another ray has this place.
                let own = distortion.is_none() || distortion.undo(image).is_some_and(|t| t.distance(tangent) < 1e-9);
                let at = frustum.picture() * image.extend(-1.0);
                (ray.z < 0.0 && own).then(|| at.truncate() / at.z)
            }
            Self::Fisheye(lens) => Some(lens.point(ray)? / circle_scale(aspect)),
        }
    }
}

/// Picture coordinates times this are units of the inscribed circle's radius.
fn circle_scale(aspect: f64) -> DVec2 {
    DVec2::new(aspect.max(1.0), (1.0 / aspect).max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::random::Random;

    const PROJECTIONS: [Projection; 5] = [
        Projection::Equidistant,
        Projection::Equisolid,
        Projection::Stereographic,
        Projection::Orthographic,
        Projection::Polynomial([1.0, -0.05, 0.002, -0.0001]),
    ];

    #[test]
    fn rays_and_pictures_are_inverse() {
        let mut random = Random::new(11);
        let frustum = Frustum { left: -0.9, right: 0.8, bottom: -0.3, top: 0.7 };
        let distortion = Distortion { radial: [-0.12, 0.03, -0.004], tangential: [0.002, -0.003] };
        let mut lenses =
            vec![Lens::Pinhole { frustum, distortion }, Lens::Pinhole { frustum, distortion: Distortion::default() }];
        for projection in PROJECTIONS {
            let aperture = projection.widest().min(PI * 170.0 / 180.0);
            let lens = FisheyeLens { projection, aperture };
            assert!(lens.is_monotone(), "{projection:?}");
            lenses.push(Lens::Fisheye(lens));
        }
        for lens in lenses {
            let mut seen = 0;
            for _ in 0..5_000 {
                let picture = DVec2::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0));
                let Some(ray) = lens.ray(picture, 1.6) else { continue };
                let back = lens.picture(ray * random.range(1e-3, 1e3), 1.6).expect("the ray is the picture's");
                // The orthographic rim is ill-conditioned by its flat sine.
                assert!(back.distance(picture) < 1e-11, "{lens:?} {picture} {back}");
                seen += 1;
            }
            assert!(seen > 1_000, "{lens:?}");
        }
    }

    #[test]
    fn projections_are_the_published_ones() {
        // Half-way to the rim of 180°: r = 1/2.
        let angle = |projection| {
            let ray = FisheyeLens { projection, aperture: PI }.direction(DVec2::new(0.5, 0.0)).expect("inside");
            ray.x.atan2(-ray.z).to_degrees()
        };
        assert!((angle(Projection::Equidistant) - 45.0).abs() < 1e-12);
        assert!((angle(Projection::Equisolid) - 41.409_622_109_270_86).abs() < 1e-12, "2·asin(√2/4)");
        assert!((angle(Projection::Stereographic) - 53.130_102_354_155_98).abs() < 1e-12, "2·atan(1/2)");
        assert!((angle(Projection::Orthographic) - 30.0).abs() < 1e-12);
        assert!((angle(Projection::Polynomial([2.0, 0.0, 0.0, 0.0])) - 45.0).abs() < 1e-12);
        let folded = Projection::Polynomial([1.0, -0.5, 0.0, 0.0]);
        assert!(!FisheyeLens { projection: folded, aperture: PI }.is_monotone());
    }

    #[test]
    fn a_fold_has_no_ray() {
        let barrel = Distortion { radial: [-0.5, 0.0, 0.0], tangential: [0.0; 2] };
        // x(1 − x²/2) is at most 0.544.
        assert!(barrel.undo(DVec2::new(0.54, 0.0)).is_some());
        assert!(barrel.undo(DVec2::new(0.56, 0.0)).is_none());
        assert!(barrel.undo(DVec2::NAN).is_none());
    }
}
