//! The passes of a rig that is being edited, over the views of the plan before.
//!
//! A program that has recorded its draws for these views cannot draw others at once.

use crate::cache::Cache;
use crate::correct::passes::output_pass::Plan;
use crate::correct::plan::builder;
use crate::error::Result;
use crate::rig::Rig;
use crate::views::{Request, ViewPlan};

/// Returns exact passes for `rig` over the views of `plan`, which was made for another rig and for
/// `request`. `drawn`: views that the program draws, one bit for each. The outputs are the same in
/// number, order and eyes.
///
/// Pixels whose directions no view shows are black. `None` if these views cannot
/// serve: some are no perspective views, or the window is content.
///
/// # Errors
/// Those of [`build`](crate::correct::build), without those of the views.
pub fn plan(rig: &Rig, request: &Request, plan: &Plan, drawn: u64, cache: &Cache) -> Result<Option<Plan>> {
    if !is_served(rig, plan) {
        return Ok(None);
    }
    let outputs = rig.outputs.iter().enumerate();
    let output_views = outputs.map(|(index, output)| views_of(plan, index, output.eye, drawn)).collect();
    let views = ViewPlan { output_views, ..plan.views.clone() };
    builder::build_over(rig, request, views, cache).map(Some)
}

/// True if the views of `plan` can show `rig`.
pub(in crate::correct) fn is_served(rig: &Rig, plan: &Plan) -> bool {
    let views = &plan.views;
    !rig.passthrough
        && rig.content.is_none()
        && rig.outputs.len() == plan.passes.len()
        && views.output_views.len() == plan.passes.len()
        && views.views.iter().all(|view| !view.program_lens && view.curved.is_none())
        && plan.passes.iter().all(|pass| pass.content.is_none())
}

/// Returns the drawn views for an output: its own first, then the others of its eye.
pub(in crate::correct) fn views_of(plan: &Plan, output: usize, eye: f64, drawn: u64) -> Vec<usize> {
    let views = &plan.views.views;
    let own = plan.views.output_views[output].iter().copied();
    let others = (0..views.len()).filter(|view| !plan.views.output_views[output].contains(view));
    let is_drawn = |view: &usize| *view < 64 && drawn >> *view & 1 == 1 && views[*view].eye == eye;
    own.chain(others).filter(is_drawn).collect()
}
