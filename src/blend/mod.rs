//! Weights of overlapping outputs, and the sum of their light that an audience sees.
//!
//! Weights are parts of **linear light**; a display's response is undone before and applied after
//! (`encoded = linear^(1/gamma)`). Where several projectors light a point of the dome, the blend
//! weight of each is `w_k = e_k / Σ e_j`. Its raw weight `e` is the product over the four sides of
//! its picture of `ramp(distance / width)`. So the weights of a point add up to 1 wherever there is
//! light, and each projector finds its own weight from the shared geometry.

mod ramp;
mod simulation;
mod weight;
mod weight_jumps;

pub use ramp::{EdgeWeight, LEAST_RAMP, ramp, smoothstep};
pub use simulation::{Picture, Simulation, Uniformity, simulate};
pub use weight::{Weights, weight};
pub use weight_jumps::{Crossing, crossings};

use crate::rig::{Blend, Transfer};

/// Linear light (0…1) of an encoded value: `encoded^gamma`. Negative values and NaN are black.
pub fn decode(encoded: f64, gamma: f64) -> f64 {
    encoded.max(0.0).powf(gamma)
}

/// Encoded value of linear light: `light^(1/gamma)`. Negative values and NaN are black.
pub fn encode(light: f64, gamma: f64) -> f64 {
    light.max(0.0).powf(1.0 / gamma)
}

/// Channel that stands for all channels where a weight is a factor on displayed values: green, the
/// brightest.
pub const GREEN: usize = 1;

/// Linear light of an encoded value on the display of `blend`, in a channel (0 red, 1 green, 2
/// blue; others are blue). Negative values and NaN are black.
pub fn light_of(encoded: f64, blend: &Blend, channel: usize) -> f64 {
    let encoded = encoded.max(0.0);
    match &blend.transfer {
        Transfer::Power => decode(encoded, blend.gamma),
        Transfer::Powers(gammas) => decode(encoded, gammas[channel.min(2)]),
        Transfer::Measured(responses) => responses[channel.min(2)].light(encoded),
        Transfer::Srgb if encoded <= 0.04045 => encoded / 12.92,
        Transfer::Srgb => ((encoded + 0.055) / 1.055).powf(2.4),
    }
}

/// Value for which the display of `blend` gives this linear light: the inverse of [`light_of`].
pub fn code_of(light: f64, blend: &Blend, channel: usize) -> f64 {
    let light = light.max(0.0);
    match &blend.transfer {
        Transfer::Power => encode(light, blend.gamma),
        Transfer::Powers(gammas) => encode(light, gammas[channel.min(2)]),
        Transfer::Measured(responses) => responses[channel.min(2)].code(light),
        Transfer::Srgb if light <= 0.003_130_8 => light * 12.92,
        Transfer::Srgb => 1.055 * light.powf(1.0 / 2.4) - 0.055,
    }
}
