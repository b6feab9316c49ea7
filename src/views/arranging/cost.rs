//! What a view costs beside its texels, in texels: submitting the program's draws once more.

use crate::rig::{Favour, Rig};
use crate::views::ViewPlan;

/// A thousand draws at 1–2 µs are 1–2 ms. In that time a graphics card shades 5–10 million texels
/// with an overdraw of 2, and a software rasteriser about 0.3 million: 2²⁰ lies between.
const TEXELS_PER_VIEW: f64 = 1_048_576.0;

/// The draws of a frame that this is for.
const USUAL_DRAWS: f64 = 1024.0;

/// Of a view; for a rig that favours one or the other 16 times as much, or as little.
pub(crate) fn beside_texels(rig: &Rig) -> f64 {
    match rig.views.favour {
        Favour::Balanced => TEXELS_PER_VIEW,
        Favour::Processor => 16.0 * TEXELS_PER_VIEW,
        Favour::Graphics => TEXELS_PER_VIEW / 16.0,
        Favour::Draws(draws) => TEXELS_PER_VIEW / USUAL_DRAWS * f64::from(draws),
    }
}

/// What a plan for `rig` costs in a frame, in texels: its views' own, and for each view what submitting the program's draws
/// once more costs.
pub fn cost(plan: &ViewPlan, rig: &Rig) -> f64 {
    plan.views.iter().map(|view| view.tile.area() as f64 + beside_texels(rig)).sum()
}
