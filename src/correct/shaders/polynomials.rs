//! Polynomials and ramps as the shaders take them.

use crate::correct::shaders::constants::limit;
use crate::correct::single;
use crate::error::Result;
use crate::geom::lenses::equidistant::{MOST_COEFFICIENTS, RadialForm, sine_cosine_polynomials};
use crate::rig::RampShape;

/// Coefficients of a polynomial in two vectors, the constant first.
pub(super) type Polynomial = [[f32; 4]; 2];

/// Returns the polynomials of an angle of `aperture/2` times a coordinate: sin(angle)/coordinate
/// and cos(angle), as functions of the coordinate's square.
pub(super) fn circular(aperture: f64) -> Result<(Polynomial, Polynomial)> {
    let half = aperture / 2.0;
    let fitted = sine_cosine_polynomials(aperture);
    let scaled = |coefficients: &[f64], factor: f64| {
        let powers = std::iter::successors(Some(factor), |power| Some(power * half * half));
        let scaled: Vec<f64> =
            coefficients.iter().zip(powers).map(|(coefficient, power)| coefficient * power).collect();
        polynomial(&scaled)
    };
    Ok((scaled(&fitted.sine, half)?, scaled(&fitted.cosine, 1.0)?))
}

/// Returns a fisheye's polynomials: sine, cosine, and (squeeze, factors of the root).
pub(super) fn radial(form: &RadialForm) -> Result<(Polynomial, Polynomial, [f32; 3])> {
    let root = single::values([form.squeeze, form.sine_root, form.cosine_root]);
    Ok((polynomial(&form.sine)?, polynomial(&form.cosine)?, root))
}

/// Returns a polynomial as the shaders take it; missing coefficients are 0.
fn polynomial(coefficients: &[f64]) -> Result<Polynomial> {
    limit("polynomial coefficients", coefficients.len(), MOST_COEFFICIENTS)?;
    let mut padded = [0.0; MOST_COEFFICIENTS];
    padded[..coefficients.len()].copy_from_slice(coefficients);
    Ok(two_vectors(padded))
}

pub(super) fn two_vectors(numbers: [f64; 8]) -> Polynomial {
    let [a, b, c, d, e, f, g, h] = single::values(numbers);
    [[a, b, c, d], [e, f, g, h]]
}

/// Returns a ramp's shape as the shaders take it: 0 = smoothstep, negative = cosine, else the
/// power.
pub(super) fn shape(shape: RampShape) -> f64 {
    match shape {
        RampShape::Smoothstep => 0.0,
        RampShape::Cosine => -1.0,
        RampShape::Power(power) => power,
    }
}
