//! Brightness of an output, pixel by pixel.

use crate::error::{Error, ErrorKind, Result};
use crate::rig::Transfer;

/// Blend weights of an output's pixels, and response of its display.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Blend {
    /// Weight from the overlap of all projectors (partition of unity).
    pub overlap: bool,
    /// Width of the ramp at a projector's borders, as a part of the picture's width or height, 0 <
    /// ramp ≤ 0.5.
    pub ramp: f64,
    /// Shape of that ramp.
    pub shape: RampShape,
    /// Exponent of a projector's claim on a point, before the point is shared out, 1…2: the
    /// greater, the shorter the transition.
    pub exponent: f64,
    /// Procedural ramps in dome angles, multiplied in.
    pub ramps: Vec<AngleRamp>,
    /// Exponent of the display's response, 1…4; of effect with [`Transfer::Power`] only.
    pub gamma: f64,
    /// The display's response.
    pub transfer: Transfer,
    /// Light added everywhere, 0 ≤ level < 1, linear.
    pub black_level: f64,
    /// White over black of a projector, at least 10; `None`: its black is dark enough.
    pub contrast: Option<f64>,
    /// Bits per channel of the display, 6…16, where its steps are to be dithered.
    pub dither: Option<u32>,
}

impl Default for Blend {
    fn default() -> Self {
        Self {
            overlap: false,
            ramp: 0.25,
            shape: RampShape::Smoothstep,
            exponent: 1.0,
            ramps: Vec::new(),
            gamma: 2.2,
            transfer: Transfer::Power,
            black_level: 0.0,
            contrast: None,
            dither: None,
        }
    }
}

impl Blend {
    /// Light of black, as a part of white.
    pub fn black(&self) -> f64 {
        self.contrast.map_or(0.0, f64::recip)
    }

    /// Checks that every value is in its range, for values that come from no rig file. Angles of
    /// ramps are not checked.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] with the first value that is not, and what would be right.
    pub fn check(&self) -> Result<()> {
        let power = match self.shape {
            RampShape::Power(power) => power,
            _ => 1.0,
        };
        let contrast = self.contrast.unwrap_or(10.0);
        let bits = f64::from(self.dither.unwrap_or(8));
        for (name, value, least, greatest) in [
            ("ramp", self.ramp, 1e-6, 0.5),
            ("power", power, 0.5, 4.0),
            ("exponent", self.exponent, 1.0, 2.0),
            ("gamma", self.gamma, 1.0, 4.0),
            ("black_level", self.black_level, 0.0, 0.999_999),
            ("contrast", contrast, 10.0, 1e9),
            ("dither", bits, 6.0, 16.0),
        ] {
            if !(least..=greatest).contains(&value) {
                let message = format!("{name} = {value}; expected {least} to {greatest}");
                return Err(Error::new(ErrorKind::InvalidArgument, message));
            }
        }
        Ok(())
    }
}

/// Shape of a ramp from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Default, serde::Serialize)]
pub enum RampShape {
    /// `3t² − 2t³`: continuous with its first derivative; steepest slope 1.5.
    #[default]
    Smoothstep,
    /// `½ − ½·cos(πt)`: the same with less curvature at the ends; 1.57.
    Cosine,
    /// `½·(2t)^p` up to the middle, then the same turned about it (Bourke 2004); steepest slope p.
    /// p is 0.5…4; 1 is a straight line.
    Power(f64),
}

/// A ramp in an angle of the dome: 0 at `zero`, 1 at `full`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct AngleRamp {
    /// Angle along which the ramp runs.
    pub angle: DomeAngle,
    /// Angle at which the weight is 0, radians.
    pub zero: f64,
    /// Angle at which the weight is 1, radians; less or greater than `zero`.
    pub full: f64,
    /// Its shape.
    pub shape: RampShape,
}

/// An angle on the dome.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum DomeAngle {
    /// From the dome's pole, 0…π.
    Polar,
    /// Around the dome's pole, 0 = front, right-positive, −π…π.
    Azimuth,
}
