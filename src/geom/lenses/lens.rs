//! Lenses: pinholes, optionally with Brown–Conrady distortion and keystone, and fisheyes.
//!
//! Positions in a picture are −1…1 from left to right and from bottom to top. Rays are in lens axes
//! (x right, y up, −z ahead). Both conversions are computed in f64. A conversion without a closed
//! form is iterated down to rounding; a point at which the iteration does not converge has no ray.

use crate::geom::{FisheyeLens, Frustum, homography};
use glam::{DMat3, DVec2, DVec3};

/// A lens of a projector.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum Lens {
    /// A pinhole, perhaps distorted.
    Pinhole {
        /// Opening of the projected picture, tangents.
        frustum: Frustum,
        /// Distortion of tangents by the lens.
        distortion: Distortion,
        /// Distortion that the projector applies before the lens: the picture that it receives,
        /// `(x, y, 1)`, → the picture that fills the opening, homogeneous
        /// ([`homography::from_corners`]).
        keystone: DMat3,
    },
    /// A fisheye.
    Fisheye {
        /// The lens.
        lens: FisheyeLens,
        /// Position and size of its circle in the picture.
        circle: Circle,
    },
}

/// Position and size of a fisheye's circle in a picture.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub enum Circle {
    /// The largest that fits, in the middle.
    Inscribed,
    /// At any position, of any size; an ellipse for an anamorphic lens.
    Placed {
        /// Its centre, picture coordinates (−1…1).
        center: DVec2,
        /// Half its width and height, picture coordinates: (1, 1) touches all four sides.
        half: DVec2,
    },
}

impl Circle {
    /// Converts picture coordinates to units of the circle's radius.
    pub fn to_disc(&self, picture: DVec2, aspect: f64) -> DVec2 {
        let (center, half) = self.placed(aspect);
        (picture - center) / half
    }

    /// The inverse of [`Self::to_disc`].
    pub fn to_picture(&self, disc: DVec2, aspect: f64) -> DVec2 {
        let (center, half) = self.placed(aspect);
        disc * half + center
    }

    fn placed(&self, aspect: f64) -> (DVec2, DVec2) {
        match *self {
            Self::Inscribed => (DVec2::ZERO, DVec2::new((1.0 / aspect).min(1.0), aspect.min(1.0))),
            Self::Placed { center, half } => (center, half),
        }
    }
}

/// Radial and tangential distortion of a pinhole's tangents after Brown (1966) and Conrady (1919):
/// `(x, y)·(1 + k₁r² + k₂r⁴ + k₃r⁶) + (2p₁xy + p₂(r² + 2x²), p₁(r² + 2y²) + 2p₂xy)` is the point at
/// which the ray `(x, y, −1)` appears.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Distortion {
    /// k₁, k₂, k₃.
    pub radial: [f64; 3],
    /// p₁, p₂.
    pub tangential: [f64; 2],
}

/// Greatest number of steps of Newton's method, which doubles the digits in each step.
const NEWTON_STEPS: usize = 30;
/// Tolerance of the search for an undistorted tangent: greatest distance of its image from the
/// point asked for.
const ARRIVED: f64 = 1e-13;

impl Distortion {
    /// True if there is no distortion.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the point at which the ray `(x, y, −1)` appears, and the derivatives by x and by y.
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

    /// Returns the tangent whose image is `image`, to 1e-13. `None` if Newton's method does not
    /// converge, or converges where the picture is folded over (the derivative's determinant is not
    /// positive).
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

impl Lens {
    /// An ideal pinhole.
    pub fn pinhole(frustum: Frustum) -> Self {
        Self::Pinhole { frustum, distortion: Distortion::default(), keystone: DMat3::IDENTITY }
    }

    /// Returns the rays of an ideal pinhole, with keystone or without: `(x, y, 1)` → ray in lens
    /// axes; `None` for other lenses.
    pub fn linear_rays(&self) -> Option<DMat3> {
        match self {
            Self::Pinhole { frustum, distortion, keystone } if distortion.is_none() => Some(frustum.rays() * *keystone),
            _ => None,
        }
    }

    /// Returns the ray (any length) of a point of a picture whose width is `aspect` times its
    /// height; `None` if the point has no ray.
    pub fn ray(&self, picture: DVec2, aspect: f64) -> Option<DVec3> {
        match self {
            Self::Pinhole { frustum, distortion, keystone } => {
                let ray = frustum.rays() * homography::apply(keystone, picture)?.extend(1.0);
                if distortion.is_none() { Some(ray) } else { Some(distortion.undo(ray.truncate())?.extend(-1.0)) }
            }
            Self::Fisheye { lens, circle } => lens.direction(circle.to_disc(picture, aspect)),
        }
    }

    /// Returns the position of a ray of any length in the picture, possibly outside −1…1: the
    /// inverse of [`Self::ray`].
    pub fn picture(&self, ray: DVec3, aspect: f64) -> Option<DVec2> {
        match self {
            Self::Pinhole { frustum, distortion, keystone } => {
                let tangent = ray.truncate() / -ray.z;
                let image = distortion.apply(tangent).0;
                // Beyond the fold of the distortion this position belongs to another ray.
                let own = distortion.is_none() || distortion.undo(image).is_some_and(|t| t.distance(tangent) < 1e-9);
                let at = frustum.picture() * image.extend(-1.0);
                if ray.z < 0.0 && own { homography::apply(&keystone.inverse(), at.truncate() / at.z) } else { None }
            }
            Self::Fisheye { lens, circle } => Some(circle.to_picture(lens.point(ray)?, aspect)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Curve, Projection};
    use crate::testing::random::Random;
    use std::f64::consts::PI;
    use std::sync::Arc;

    fn projections() -> [Projection; 6] {
        let curve = Curve::new(&[[0.4, 0.41], [0.9, 0.86], [1.3, 1.18], [1.6, 1.35]]).expect("rising");
        [
            Projection::Equidistant,
            Projection::Equisolid,
            Projection::Stereographic,
            Projection::Orthographic,
            Projection::Polynomial([1.0, -0.05, 0.002, -0.0001]),
            Projection::Measured(Arc::new(curve)),
        ]
    }

    #[test]
    fn rays_and_pictures_are_inverse() {
        let mut random = Random::new(11);
        let frustum = Frustum { left: -0.9, right: 0.8, bottom: -0.3, top: 0.7 };
        let distortion = Distortion { radial: [-0.12, 0.03, -0.004], tangential: [0.002, -0.003] };
        let corners = [(-0.9, -1.0), (1.0, -0.8), (0.8, 0.9), (-1.0, 1.0)].map(DVec2::from);
        let keystone = homography::from_corners(corners).expect("convex");
        let mut lenses = vec![Lens::pinhole(frustum), Lens::Pinhole { frustum, distortion, keystone }];
        let ellipse = Circle::Placed { center: DVec2::new(0.1, -0.2), half: DVec2::new(1.1, 0.9) };
        for (index, projection) in projections().into_iter().enumerate() {
            let aperture = projection.widest().min(PI * 170.0 / 180.0);
            let lens = FisheyeLens { projection, aperture };
            assert!(lens.is_monotone(), "{lens:?}");
            lenses.push(Lens::Fisheye { lens, circle: if index % 2 == 0 { Circle::Inscribed } else { ellipse } });
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
    fn a_squeezed_circle_touches_where_it_says() {
        let lens = FisheyeLens { projection: Projection::Equidistant, aperture: PI };
        let circle = Circle::Placed { center: DVec2::new(0.0, -0.1), half: DVec2::new(1.0, 0.5) };
        let ray = |x, y| Lens::Fisheye { lens: lens.clone(), circle }.ray(DVec2::new(x, y), 2.0);
        let near = |found: Option<DVec3>, right: DVec3| assert!(found.is_some_and(|f| f.distance(right) < 1e-15));
        near(ray(1.0, -0.1), DVec3::X);
        near(ray(0.0, 0.4), DVec3::Y);
        near(ray(0.0, -0.1), DVec3::NEG_Z);
        assert_eq!(ray(0.0, 0.401), None);
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
