//! Cost of a view beside its texels, in texels: the program's draws are submitted once more.

use crate::rig::{Favour, Rig, ViewMethod};
use crate::views::view_plan::ViewPlan;

/// Cost of a view beside its texels, in texels. A thousand draws at 1–2 µs are 1–2 ms. In that time
/// a graphics card shades 5–10 million texels with an overdraw of 2, and a software rasteriser
/// about 0.3 million: 2²⁰ lies between.
const TEXELS_PER_VIEW: f64 = 1_048_576.0;

/// Number of draws of a frame for which [`TEXELS_PER_VIEW`] holds.
const USUAL_DRAWS: f64 = 1024.0;

/// The keys of `[views]` that the steps of the planner read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlannerOptions {
    /// Texels per pixel.
    pub quality: f64,
    /// Families of views that are allowed.
    pub method: ViewMethod,
    /// Resource that is scarce.
    pub favour: Favour,
    /// True if the rig gives the cells of the shared views.
    pub given_cells: bool,
}

impl PlannerOptions {
    /// Returns the options of a rig.
    pub fn of(rig: &Rig) -> Self {
        let views = &rig.views;
        Self {
            quality: views.quality,
            method: views.method,
            favour: views.favour,
            given_cells: !views.cells.is_empty(),
        }
    }

    /// Returns the cost of a view beside its texels, in texels; 16 times as much, or a sixteenth,
    /// for a rig that favours one resource.
    pub fn texels_per_draw_set(&self) -> f64 {
        match self.favour {
            Favour::Balanced => TEXELS_PER_VIEW,
            Favour::Processor => 16.0 * TEXELS_PER_VIEW,
            Favour::Graphics => TEXELS_PER_VIEW / 16.0,
            Favour::Draws(draws) => TEXELS_PER_VIEW / USUAL_DRAWS * f64::from(draws),
        }
    }
}

/// Returns the cost of a plan for `rig` in a frame, in texels: the texels of its views, and for
/// each view the cost of submitting the program's draws once more.
pub fn cost(plan: &ViewPlan, rig: &Rig) -> f64 {
    let beside = PlannerOptions::of(rig).texels_per_draw_set();
    plan.views.iter().map(|view| view.tile.area() as f64 + beside).sum()
}
