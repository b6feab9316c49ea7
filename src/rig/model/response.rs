//! Light that a display makes of encoded values.

use crate::geom::Curve;
use std::sync::Arc;

/// Function from encoded values to light.
#[derive(Clone, Debug, PartialEq, Default, serde::Serialize)]
pub enum Transfer {
    /// The power `gamma`, the same for all channels.
    #[default]
    Power,
    /// The curve of sRGB (IEC 61966-2-1): a power of 2.4 with a straight line near black.
    Srgb,
    /// A power for each of red, green and blue, 1…4.
    Powers([f64; 3]),
    /// A measured response for each of red, green and blue.
    Measured(Arc<[Response; 3]>),
}

impl Transfer {
    /// True if it is the same power for all channels, so that a factor on light is a factor on
    /// values.
    pub fn is_plain(&self) -> bool {
        matches!(self, Self::Power)
    }
}

/// Number of steps of the light's fourth root between the points of a [`Response`].
pub const RESPONSE_STEPS: usize = 32;

/// A measured response: the values (0…1) at which the fourth root of the light is 0, 1/32, 2/32 …
/// 1, with straight lines between these points.
///
/// As functions of the fourth root, responses of displays are nearly straight, most of all near
/// black, and the shaders need no power. Both directions use the same points, so that each is the
/// inverse of the other. The straight lines deviate from the curve by at most 6·10⁻⁴ of white for
/// displays with a power of 1.8…2.4, and by 1.6·10⁻³ (0.4 steps of 8 bits) for 1…4.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Response {
    #[serde(serialize_with = "as_slice")]
    codes: [f64; RESPONSE_STEPS + 1],
}

/// Serialises an array of any length.
fn as_slice<S: serde::Serializer>(numbers: &[f64], to: S) -> std::result::Result<S::Ok, S::Error> {
    serde::Serialize::serialize(numbers, to)
}

impl Response {
    /// Makes a response from at least two `points` of value and light, both growing, in any units.
    /// The first is black, whose value must be 0 and whose light is subtracted from all others; the
    /// last is white. Between them the curve is a monotone cubic of the light's fourth root. `None`
    /// if they do not grow, are not finite, or do not begin at the value 0.
    pub fn measured(points: &[[f64; 2]]) -> Option<Self> {
        let (&[zero, black], &[full, white]) = (points.first()?, points.last()?);
        if zero != 0.0 || !(full > 0.0 && white > black) {
            return None;
        }
        let root = |light: f64| ((light - black) / (white - black)).max(0.0).sqrt().sqrt();
        let scaled: Vec<[f64; 2]> = points[1..].iter().map(|&[code, light]| [root(light), code / full]).collect();
        let curve = Curve::new(&scaled)?;
        let mut codes = std::array::from_fn(|step| curve.at(step as f64 / RESPONSE_STEPS as f64).0);
        (codes[0], codes[RESPONSE_STEPS]) = (0.0, 1.0);
        codes.windows(2).all(|pair| pair[1] > pair[0]).then_some(Self { codes })
    }

    /// Returns the response of a power, 1…4.
    pub fn power(gamma: f64) -> Self {
        let codes = std::array::from_fn(|step| (step as f64 / RESPONSE_STEPS as f64).powf(4.0 / gamma));
        Self { codes }
    }

    /// Values at 0, 1/32, … 1 of the light's fourth root.
    pub fn codes(&self) -> &[f64; RESPONSE_STEPS + 1] {
        &self.codes
    }

    /// Light of a value; below 0 and above 1 that of black and white.
    pub fn light(&self, code: f64) -> f64 {
        let part = |pair: &[f64]| ((code - pair[0]) / (pair[1] - pair[0])).clamp(0.0, 1.0);
        (self.codes.windows(2).map(part).sum::<f64>() / RESPONSE_STEPS as f64).powi(4)
    }

    /// Value of this light; below 0 and above 1 that of black and white.
    pub fn code(&self, light: f64) -> f64 {
        let place = light.max(0.0).sqrt().sqrt() * RESPONSE_STEPS as f64;
        let steps = self.codes.windows(2).enumerate();
        steps.map(|(step, pair)| (pair[1] - pair[0]) * (place - step as f64).clamp(0.0, 1.0)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measured_power_is_that_power_and_both_directions_undo_each_other() {
        for (gamma, bound) in [(1.0, 1.6e-3), (1.8, 4e-4), (2.2, 4.5e-4), (2.4, 6e-4), (3.3, 1.2e-3), (4.0, 1e-12)] {
            // Candela per square metre over 8-bit codes, with a bright black.
            let points: Vec<[f64; 2]> =
                (0..=255).map(|c| [f64::from(c), 0.3 + 120.0 * (f64::from(c) / 255.0f64).powf(gamma)]).collect();
            let response = Response::measured(&points).expect("growing");
            for i in 0..=1000 {
                let code = f64::from(i) / 1000.0;
                let light = response.light(code);
                assert!((response.code(light) - code).abs() < 1e-12, "{gamma} {code}");
                let error = (Response::power(gamma).code(code.powf(gamma)) - code).abs();
                assert!(error < bound, "{gamma} {code}: {error:e}");
            }
            // At the measured values the error is within the documented bound. Between black and
            // the first step of 8 bits the points are unknown, and the straight lines from there
            // extend beyond that step.
            let stated = if (1.8..=2.4).contains(&gamma) { 6e-4 } else { 1.6e-3 };
            for step in 0..=255 {
                let code = f64::from(step) / 255.0;
                let error = (response.code(code.powf(gamma)) - code).abs();
                assert!(error < stated, "measured {gamma} {code}: {error:e}");
            }
            assert_eq!((response.light(0.0), response.light(1.0), response.code(0.0)), (0.0, 1.0, 0.0));
        }
        // Negative control: the response of another display.
        assert!((Response::power(2.2).code(0.2) - Response::power(2.3).code(0.2)).abs() > 5e-3);
    }

    #[test]
    fn few_points_will_do_and_what_does_not_grow_is_refused() {
        let nine: Vec<[f64; 2]> = (0..9).map(|i| [f64::from(i) * 32.0, f64::from(i * i)]).collect();
        let response = Response::measured(&nine).expect("growing");
        assert!((response.light(0.6) - 0.36).abs() < 2e-3, "{}", response.light(0.6));
        for bad in [
            &[][..],
            &[[0.0, 0.0]],
            &[[0.1, 0.0], [1.0, 1.0]],
            &[[0.0, 1.0], [1.0, 1.0]],
            &[[0.0, 0.0], [0.5, 0.7], [0.4, 0.8], [1.0, 1.0]],
            &[[0.0, 0.0], [0.5, 0.7], [0.6, 0.6], [1.0, 1.0]],
            &[[0.0, 0.0], [0.5, f64::NAN], [1.0, 1.0]],
            &[[0.0, 0.0], [1.0, f64::INFINITY]],
        ] {
            assert_eq!(Response::measured(bad), None, "{bad:?}");
        }
    }
}
