//! Brightness of an output for each pixel.

use crate::error::{Error, ErrorKind, Result};
use crate::rig::Transfer;

/// Blend weights of an output's pixels, and response of its display.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Blend {
    /// True if the overlap of all projectors gives a weight (partition of unity).
    pub overlap: bool,
    /// Width of the ramp at a projector's borders, as a part of the picture's width or height, 0 <
    /// ramp ≤ 0.5.
    pub ramp: f64,
    /// Shape of that ramp.
    pub shape: RampShape,
    /// Exponent of a projector's raw weight, 1…2: a greater one makes the transition shorter.
    pub exponent: f64,
    /// Procedural ramps in dome angles, multiplied in.
    pub ramps: Vec<AngleRamp>,
    /// Exponent of the display's response, 1…4; it is used only with [`Transfer::Power`].
    pub gamma: f64,
    /// Response of the display.
    pub transfer: Transfer,
    /// Light added everywhere, 0 ≤ level < 1, linear.
    pub black_level: f64,
    /// Light of a projector's white divided by that of its black, at least 10; `None` if its black
    /// is dark enough.
    pub contrast: Option<f64>,
    /// Bits per channel of the display, 6…16, if its steps are dithered.
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

    /// Checks that every value is in its range, for values that do not come from a rig file. Angles
    /// of ramps are not checked.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] with the first value out of range, and with the range.
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
    /// `½ − ½·cos(πt)`: continuous as well, with less curvature at the ends; steepest slope 1.57.
    Cosine,
    /// `½·(2t)^p` up to the middle, then the same turned about it (Bourke 2004), p = 0.5…4;
    /// steepest slope p. With p = 1 it is a straight line.
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
    /// Shape of the ramp.
    pub shape: RampShape,
}

/// An angle on the dome.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum DomeAngle {
    /// Angle from the dome's pole, 0…π.
    Polar,
    /// Angle around the dome's pole, 0 = front, right-positive, −π…π.
    Azimuth,
}
