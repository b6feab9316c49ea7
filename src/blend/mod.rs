//! Weights of overlapping outputs, and what an audience sees of the sum.
//!
//! Weights are parts of **linear light**; a display's response is undone before and applied after
//! (`encoded = linear^(1/gamma)`). Where several projectors light a point of the dome, the weight of each is
//! `w_k = e_k / Σ e_j`, with `e` the product over the four sides of its picture of
//! `smoothstep(distance / ramp)`: the weights of a point add up to 1 wherever there is light, and each projector finds
//! its own from the shared geometry.

mod simulation;
mod weight;

pub use simulation::{Picture, Simulation, Uniformity, simulate};
pub use weight::{Weights, edge_weight, smoothstep, weight};

/// The linear light (0…1) of an encoded value: `encoded^gamma`. Negative values and NaN are black.
pub fn decode(encoded: f64, gamma: f64) -> f64 {
    encoded.max(0.0).powf(gamma)
}

/// The encoded value of linear light: `light^(1/gamma)`. Negative values and NaN are black.
pub fn encode(light: f64, gamma: f64) -> f64 {
    light.max(0.0).powf(1.0 / gamma)
}
