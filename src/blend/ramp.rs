//! Shapes of ramps, and raw blend weights.

use crate::rig::{Blend, RampShape};
use glam::DVec2;

/// Least width of a ramp. A narrower ramp has this width, because a ramp of width 0 is undefined in
/// shading languages.
pub const LEAST_RAMP: f64 = 1e-6;

/// Returns `3t² − 2t³` for t in 0…1, constant outside: continuous with its first derivative.
pub fn smoothstep(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A ramp of `shape` at `t`: 0 below 0, 1 above 1.
pub fn ramp(shape: RampShape, t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    match shape {
        RampShape::Smoothstep => smoothstep(t),
        RampShape::Cosine => 0.5 - 0.5 * (std::f64::consts::PI * t).cos(),
        RampShape::Power(power) if t < 0.5 => 0.5 * (2.0 * t).powf(power),
        RampShape::Power(power) => 1.0 - 0.5 * (2.0 - 2.0 * t).powf(power),
    }
}

/// Decrease of a projector's raw weight towards the edges of its picture, and brightness of its
/// black.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct EdgeWeight {
    /// Width of the ramp, as a part of the picture's width and height.
    pub width: f64,
    /// Shape of the ramp.
    pub shape: RampShape,
    /// Exponent of the raw weight.
    pub exponent: f64,
    /// Light of black, as a part of white.
    pub black: f64,
}

impl EdgeWeight {
    /// Returns the edge weight of an output's picture.
    pub fn of(blend: &Blend) -> Self {
        Self { width: blend.ramp, shape: blend.shape, exponent: blend.exponent, black: blend.black() }
    }

    /// Returns the raw weight of a point at a position in the picture (parts of width and height,
    /// 0…1 inside): the product over the four sides of `ramp(distance/width)`, to the power of the
    /// exponent. 0 outside.
    pub fn raw_weight(&self, part: DVec2) -> f64 {
        let width = self.width.max(LEAST_RAMP);
        let sides = [part.x, 1.0 - part.x, part.y, 1.0 - part.y];
        sides.into_iter().map(|distance| ramp(self.shape, distance / width)).product::<f64>().powf(self.exponent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_rise_from_0_to_1_as_steeply_as_is_said() {
        for (shape, slope) in [
            (RampShape::Smoothstep, 1.5),
            (RampShape::Cosine, std::f64::consts::FRAC_PI_2),
            (RampShape::Power(1.0), 1.0),
            (RampShape::Power(2.0), 2.0),
        ] {
            let steps: Vec<f64> = (-100..=1100).map(|i| ramp(shape, f64::from(i) * 1e-3)).collect();
            assert_eq!((steps[0], steps[1200]), (0.0, 1.0));
            let steepest = steps.windows(2).map(|pair| (pair[1] - pair[0]) * 1e3).fold(0.0, f64::max);
            assert!((steepest - slope).abs() < 0.01, "{shape:?}: {steepest}");
            assert!(steps.windows(2).all(|pair| pair[1] >= pair[0]));
            // The ramps of two neighbours add up to 1.
            let sums = steps.iter().zip(steps.iter().rev()).map(|(a, b)| a + b);
            assert!(sums.into_iter().all(|sum| (sum - 1.0).abs() < 1e-12), "{shape:?}");
        }
    }
}
