//! The ideal fisheye lens, and the polynomials with which shaders evaluate it.

use crate::geom::{FisheyeLens, Projection};
use glam::{DVec2, DVec3};

/// An equidistant fisheye: the distance from the image's centre grows in proportion to the angle
/// from the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fisheye {
    /// Full opening angle in radians, 0 < aperture ≤ 2π; the rim of the unit disc is at half of it.
    pub aperture: f64,
}

impl Fisheye {
    /// Returns the unit direction (lens axes: x right, y up, −z the lens axis) of a point of the
    /// unit disc; `None` outside the disc and for NaN. The centre is exactly −z.
    pub fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let radius_squared = x * x + y * y;
        if radius_squared.is_nan() || radius_squared > 1.0 {
            return None;
        }
        let angle = 0.5 * self.aperture * radius_squared.sqrt();
        let (sine, cosine) = angle.sin_cos();
        let factor = if angle > 0.0 { sine / angle * 0.5 * self.aperture } else { 0.5 * self.aperture };
        Some(DVec3::new(x * factor, y * factor, -cosine))
    }

    /// Returns the point of the picture that shows a direction of any length (lens axes): it is in
    /// the unit disc iff the direction is within the aperture. Needs no arccosine, whose error near
    /// the axis would be √ε. The axis and the zero vector are at the centre; the antipode of the
    /// axis, which is a whole circle of the picture, gets the rightmost point of that circle.
    pub fn point(&self, direction: DVec3) -> DVec2 {
        let scale = direction.abs().max_element();
        if scale == 0.0 {
            return DVec2::ZERO;
        }
        let direction = direction / scale;
        let sine = direction.truncate().length();
        let angle = sine.atan2(-direction.z);
        let radius = 2.0 * angle / self.aperture;
        if sine > 0.0 { direction.truncate() * (radius / sine) } else { DVec2::new(radius, 0.0) }
    }
}

/// Polynomials of the lens `v = (q·S(s), −C(s))`, with `q = (x, y)·aperture/2` and `s = |q|²`: S is
/// `sin√s/√s` and C is `cos√s`, both entire functions of s, so no root, division or singular axis
/// remains.
#[derive(Clone, Debug, PartialEq)]
pub struct FisheyePolynomials {
    /// Coefficients of S, the constant first.
    pub sine: Vec<f64>,
    /// Coefficients of C, the constant first.
    pub cosine: Vec<f64>,
    /// Greatest distance of the fitted vector from the exact unit vector over the whole disc; that
    /// is an angle in radians.
    pub residual: f64,
}

/// Greatest residual of [`sine_cosine_polynomials`], in pixels of a picture 4096 wide.
pub const FISHEYE_RESIDUAL_PIXELS: f64 = 1e-4;

/// Coefficients `P` of `atan(x) ≈ x + x·s·P(s)`, `s = x²`, for 0 ≤ x ≤ 1, the constant first.
/// Relative error ≤ 1.7e-8 (minimax, Remez exchange), evaluated with additions and multiplications
/// only, which every driver rounds correctly. For other arguments: `atan2(y, x)` from `min/max` of
/// the absolute values and the octant.
pub const ATAN_COEFFICIENTS: [f64; 8] =
    [-0.3333315274, 0.1999377284, -0.1421105534, 0.1066600478, -0.0755221462, 0.043211865, -0.0163679307, 0.0029206929];

/// Polynomials for a fisheye of any projection, with r = 1 at the rim and s = r²: `v = ((x,
/// y)·(S(s) + sine_root·w), −(C(s) + cosine_root·w))`, `w = √(1 − squeeze·s)`, any length.
///
/// Stereographic, equisolid and orthographic lenses have this form exactly; the others are fitted.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct RadialForm {
    /// Coefficients of S, the constant first.
    pub sine: Vec<f64>,
    /// Coefficients of C, the constant first.
    pub cosine: Vec<f64>,
    /// Factor of s under the root.
    pub squeeze: f64,
    /// Factor of the root in the part across the axis.
    pub sine_root: f64,
    /// Factor of the root in the part along the axis.
    pub cosine_root: f64,
}

/// Greatest number of coefficients of each polynomial of [`RadialForm`].
pub const MOST_COEFFICIENTS: usize = 8;

impl RadialForm {
    /// Returns the form of a lens; `None` if no polynomials of [`MOST_COEFFICIENTS`] come within
    /// [`FISHEYE_RESIDUAL_PIXELS`].
    pub fn of(lens: &FisheyeLens) -> Option<Self> {
        let polynomials = |sine, cosine| Self { sine, cosine, squeeze: 0.0, sine_root: 0.0, cosine_root: 0.0 };
        let half = 0.5 * lens.aperture;
        match lens.projection {
            Projection::Stereographic => {
                let rim = (0.5 * half).tan();
                Some(polynomials(vec![2.0 * rim], vec![1.0, -rim * rim]))
            }
            Projection::Equisolid => {
                let rim = (0.5 * half).sin();
                let exact = polynomials(vec![0.0], vec![1.0, -2.0 * rim * rim]);
                Some(Self { squeeze: rim * rim, sine_root: 2.0 * rim, ..exact })
            }
            Projection::Orthographic => {
                let rim = half.sin();
                Some(Self { squeeze: rim * rim, cosine_root: 1.0, ..polynomials(vec![rim], vec![0.0]) })
            }
            Projection::Equidistant | Projection::Polynomial(_) | Projection::Measured(_) => {
                // The narrowest pixel decides the allowed error.
                let pixel = samples(1.0).map(|s| lens.slope(s.sqrt())).fold(f64::INFINITY, f64::min) * 2.0 / 4096.0;
                let allowed = 0.5 * FISHEYE_RESIDUAL_PIXELS * pixel;
                let angle = |s: f64| lens.angle(s.sqrt());
                let quotient = |s: f64| if s > 0.0 { angle(s).sin() / s.sqrt() } else { lens.slope(0.0) };
                let (sine, cosine) =
                    (fit(1.0, allowed, quotient, |s| s.sqrt()), fit(1.0, allowed, |s| angle(s).cos(), |_| 1.0));
                let error = samples(1.0).map(|s| {
                    let across = s.sqrt() * (polynomial_at(&sine, s) - quotient(s));
                    across.hypot(polynomial_at(&cosine, s) - angle(s).cos())
                });
                let good = error.fold(0.0, f64::max) <= FISHEYE_RESIDUAL_PIXELS * pixel;
                let short = sine.len().max(cosine.len()) <= MOST_COEFFICIENTS;
                (good && short).then(|| polynomials(sine, cosine))
            }
        }
    }

    /// Returns the direction, of any length, at a point of the unit disc, as the shader computes
    /// it.
    pub fn direction(&self, point: DVec2) -> DVec3 {
        let s = point.length_squared();
        let root = (1.0 - self.squeeze * s).max(0.0).sqrt();
        let across = polynomial_at(&self.sine, s) + self.sine_root * root;
        (point * across).extend(-(polynomial_at(&self.cosine, s) + self.cosine_root * root))
    }
}

/// Fits the polynomials for an aperture (radians, 0 < aperture ≤ 2π): interpolation at Chebyshev
/// nodes in s, of the lowest degrees whose residual stays below [`FISHEYE_RESIDUAL_PIXELS`].
pub fn sine_cosine_polynomials(aperture: f64) -> FisheyePolynomials {
    let limit = 0.5 * aperture;
    let end = limit * limit;
    // Each of the two polynomials gets half of the allowed error.
    let allowed = 0.5 * FISHEYE_RESIDUAL_PIXELS * aperture / 4096.0;
    let sine = fit(end, allowed, sine_quotient, |s| s.sqrt());
    let cosine = fit(end, allowed, |s| s.sqrt().cos(), |_| 1.0);
    let residual = samples(end)
        .map(|s| {
            let sine_error = s.sqrt() * (polynomial_at(&sine, s) - sine_quotient(s));
            sine_error.hypot(polynomial_at(&cosine, s) - s.sqrt().cos())
        })
        .fold(0.0, f64::max);
    FisheyePolynomials { sine, cosine, residual }
}

/// `sin√s/√s`.
fn sine_quotient(s: f64) -> f64 {
    let root = s.sqrt();
    if root > 0.0 { root.sin() / root } else { 1.0 }
}

/// Values of s at which a fit over 0…`end` is checked, dense enough that no extremum of the error
/// is missed between them.
fn samples(end: f64) -> impl Iterator<Item = f64> {
    (0..=2000).map(move |i| end * f64::from(i) / 2000.0)
}

/// Returns the polynomial of lowest degree whose error, times `weight`, stays within `allowed`.
fn fit(end: f64, allowed: f64, function: impl Fn(f64) -> f64, weight: impl Fn(f64) -> f64) -> Vec<f64> {
    // Degree 12 reaches the rounding of f64 for the widest aperture.
    for degree in 1..12 {
        let candidate = interpolate(end, degree, &function);
        let within = |s: f64| (weight(s) * (polynomial_at(&candidate, s) - function(s))).abs() <= allowed;
        if samples(end).all(within) {
            return candidate;
        }
    }
    interpolate(end, 12, &function)
}

/// Returns the polynomial (in powers of s) that agrees with `function` at the Chebyshev nodes of
/// 0…`end`.
fn interpolate(end: f64, degree: usize, function: impl Fn(f64) -> f64) -> Vec<f64> {
    let count = degree + 1;
    let angle = |node: usize| std::f64::consts::PI * (node as f64 + 0.5) / count as f64;
    let values: Vec<f64> = (0..count).map(|node| function(0.5 * end * (1.0 + angle(node).cos()))).collect();
    // T_k(u) with u = 2s/end − 1, in powers of s, by the three-term recurrence.
    let mut previous = vec![0.0; count];
    let mut current = vec![0.0; count];
    let mut sum = vec![0.0; count];
    for k in 0..count {
        let next = match k {
            0 => unit(count),
            1 => shifted(&current, end),
            _ => shifted(&current, end).iter().zip(&previous).map(|(a, b)| 2.0 * a - b).collect(),
        };
        previous = std::mem::replace(&mut current, next);
        let norm = if k == 0 { 1.0 } else { 2.0 } / count as f64;
        let terms = values.iter().enumerate().map(|(node, value)| value * (k as f64 * angle(node)).cos());
        let coefficient = norm * terms.sum::<f64>();
        for (total, power) in sum.iter_mut().zip(&current) {
            *total += coefficient * power;
        }
    }
    sum
}

/// The constant 1 as a polynomial of `count` coefficients.
fn unit(count: usize) -> Vec<f64> {
    let mut one = vec![0.0; count];
    one[0] = 1.0;
    one
}

/// A polynomial in s times `u = 2s/end − 1`.
fn shifted(polynomial: &[f64], end: f64) -> Vec<f64> {
    (0..polynomial.len())
        .map(|i| if i > 0 { 2.0 / end * polynomial[i - 1] - polynomial[i] } else { -polynomial[i] })
        .collect()
}

/// The value of a polynomial whose constant comes first.
pub fn polynomial_at(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Curve;
    use crate::testing::random::Random;
    use std::f64::consts::{FRAC_PI_2, PI, TAU};
    use std::sync::Arc;

    const APERTURES: [f64; 8] = [0.01, 0.5, FRAC_PI_2, PI, 210.0 / 180.0 * PI, 4.0 / 3.0 * PI, 6.0, TAU];

    #[test]
    fn radial_forms_are_their_lenses() {
        let curve = Curve::new(&[[0.5, 0.51], [1.0, 0.98], [1.6, 1.5]]).expect("rising");
        let lenses = [
            (Projection::Equidistant, PI, 1e-4),
            (Projection::Equisolid, TAU, 1e-9),
            (Projection::Stereographic, 6.0, 1e-9),
            (Projection::Orthographic, PI, 1e-9),
        ];
        for (projection, aperture, allowed) in lenses {
            let lens = FisheyeLens { projection, aperture };
            let form = RadialForm::of(&lens).expect("has one");
            for step in 0..=1_000 {
                // The outermost thousandth is left out: near the rim the roots are lost in
                // rounding.
                let radius = 0.999 * f64::from(step) / 1_000.0;
                let point = DVec2::from_angle(0.7) * radius;
                let (found, exact) = (form.direction(point).normalize(), lens.direction(point).expect("inside"));
                // At the rim of 360° and of an orthographic half sphere a pixel can cover any
                // angle.
                let pixel = lens.slope(radius).min(1e3) * 2.0 / 4096.0;
                assert!(found.distance(exact) <= allowed * pixel.max(1e-3), "{lens:?} {radius}: {found} {exact}");
            }
        }
        // Lenses without an exact form are fitted as closely, or have no form (they use a table).
        let curve = Projection::Measured(Arc::new(curve));
        for projection in [curve, Projection::Polynomial([1.0, -0.05, 0.002, 0.0]), Projection::Equidistant] {
            let lens = FisheyeLens { projection, aperture: 3.0 };
            let Some(form) = RadialForm::of(&lens) else { continue };
            for step in 0..=1_000 {
                let point = DVec2::X * (0.999 * f64::from(step) / 1_000.0);
                let (found, exact) = (form.direction(point).normalize(), lens.direction(point).expect("inside"));
                assert!(found.distance(exact) < 1e-6, "{lens:?} {point}");
            }
        }
    }

    #[test]
    fn point_and_direction_are_inverse() {
        let mut random = Random::new(6);
        for aperture in APERTURES {
            let lens = Fisheye { aperture };
            for _ in 0..20_000 {
                let (radius, azimuth) = (random.unit().sqrt() * 0.999_999, random.range(0.0, TAU));
                let point = DVec2::new(radius * azimuth.cos(), radius * azimuth.sin());
                let Some(direction) = lens.direction(point.x, point.y) else { panic!("inside the disc") };
                assert!((direction.length() - 1.0).abs() < 1e-14);
                let scale = 10f64.powf(random.range(-300.0, 300.0));
                // At the rim of 360° the azimuth itself is ill-conditioned: the whole circle is one
                // direction.
                let conditioned = 1.0 / direction.truncate().length().max(1e-9);
                let error = lens.point(direction * scale).distance(point) * (0.5 * aperture).min(1.0);
                assert!(error < 1e-15 * conditioned + 4e-15, "{aperture} {radius} {error:e}");
            }
        }
    }

    #[test]
    fn known_directions() {
        let lens = Fisheye { aperture: PI };
        assert_eq!(lens.direction(0.0, 0.0), Some(DVec3::NEG_Z));
        for (x, y, expected) in [(1.0, 0.0, DVec3::X), (0.0, 1.0, DVec3::Y), (0.0, -1.0, DVec3::NEG_Y)] {
            assert!(lens.direction(x, y).is_some_and(|d| d.distance(expected) < 1e-15));
            assert!(lens.point(expected * 3.0).distance(DVec2::new(x, y)) < 1e-15);
        }
        assert!(
            lens.direction(0.5, 0.0).is_some_and(|d| (d.x / -d.z - 1.0).abs() < 1e-15),
            "equidistant: 45° half-way"
        );
        assert_eq!(lens.direction(0.8, 0.8), None);
        assert_eq!(lens.direction(f64::NAN, 0.0), None);
        assert_eq!(lens.point(DVec3::Z), DVec2::new(2.0, 0.0), "the antipode is defined");
        assert_eq!(lens.point(DVec3::NEG_Z * 1e300), DVec2::ZERO);
        assert_eq!(lens.point(DVec3::ZERO), DVec2::ZERO);
    }

    #[test]
    fn near_the_axis_nothing_is_lost() {
        // The arccosine form would give 0 or 1.5e-8 here.
        let lens = Fisheye { aperture: PI };
        let point = lens.point(DVec3::new(1e-12, 0.0, -1.0));
        assert!((point.x / (1e-12 / FRAC_PI_2) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn polynomials_are_within_their_residual() {
        for aperture in APERTURES {
            let fitted = sine_cosine_polynomials(aperture);
            let pixel = aperture / 4096.0;
            assert!(fitted.residual < FISHEYE_RESIDUAL_PIXELS * pixel, "{aperture}: {:e}", fitted.residual / pixel);
            assert!(fitted.sine.len() <= 8 && fitted.cosine.len() <= 8, "{aperture}: {}", fitted.cosine.len());
            let lens = Fisheye { aperture };
            for i in 0..777 {
                let x = f64::from(i) / 777.0;
                let q = x * 0.5 * aperture;
                let v = DVec3::new(q * polynomial_at(&fitted.sine, q * q), 0.0, -polynomial_at(&fitted.cosine, q * q));
                let exact = lens.direction(x, 0.0).unwrap_or_default();
                assert!(v.distance(exact) <= fitted.residual * 1.01 + 1e-16);
            }
            // Negative control: the polynomials of a narrower lens are wrong for a wider one.
            if aperture > 1.0 {
                let narrow = sine_cosine_polynomials(0.6 * aperture);
                let s = 0.25 * aperture * aperture;
                assert!((polynomial_at(&narrow.cosine, s) - s.sqrt().cos()).abs() > FISHEYE_RESIDUAL_PIXELS * pixel);
            }
        }
    }

    #[test]
    fn arctangent_polynomial_is_as_good_as_documented() {
        for i in 1..=10_000 {
            let x = f64::from(i) / 10_000.0;
            let value = x + x * x * x * polynomial_at(&ATAN_COEFFICIENTS, x * x);
            assert!((value / x.atan() - 1.0).abs() < 1.7e-8, "{x}");
        }
    }
}
