//! The planner's steps in order: sample, arrange, place, remove views that no pixel samples.

use crate::cache::Cache;
use crate::error::Result;
use crate::rig::Rig;
use crate::views::arranging::cached;
use crate::views::placing::{idle, layout};
use crate::views::sampling::output_map;
use crate::views::view_plan::{Request, ViewPlan};

/// Plans the views of `rig`: deterministic, and without a graphics API.
///
/// A rig with `passthrough` has no views. Every direction that an output shows at a pixel's
/// centre lies in `owned` of at least one view of `output_views[output]`, by a quarter of a texel
/// where views meet or end, and the bilinear footprint of every sample stays inside the tile.
///
/// # Errors
///
/// [`InvalidArgument`](crate::ErrorKind::InvalidArgument) if one side of a size is 0 or the list of sizes has the wrong
/// length; [`InvalidRig`](crate::ErrorKind::InvalidRig) if `method` is [`Single`](crate::rig::ViewMethod::Single) and
/// an output sees too much for one perspective view; [`Graphics`](crate::ErrorKind::Graphics) if nothing fits into
/// the atlas. Where only the resolution must be reduced to fit, the plan says so in `notes`.
pub fn plan(rig: &Rig, request: &Request) -> Result<ViewPlan> {
    plan_with_margin(rig, request, 0, &Cache::none())
}

/// As [`plan`], for outputs that sample up to so many texels beside the exact place; `cache` may
/// know what is chosen, or keeps it.
///
/// # Errors
/// As [`plan`].
pub fn plan_with_margin(rig: &Rig, request: &Request, margin: u32, cache: &Cache) -> Result<ViewPlan> {
    // A mirrored picture shows the same directions.
    let rig = &*rig.upright();
    let outputs: &[_] = if rig.passthrough { &[] } else { &rig.outputs };
    request.check(outputs.len(), rig.passthrough)?;
    let output_maps = output_map::all(rig, outputs.len(), request)?;
    let mut arrangement = cached::arrange(rig, &output_maps, cache)?;
    loop {
        let plan = layout::place(rig, request, margin, &arrangement.views, &arrangement.notes)?;
        let Some(idle) = idle::find(&plan, &output_maps) else { return Ok(plan) };
        let view = arrangement.views.remove(idle);
        arrangement.notes.push(format!("no view {}: the centre of no pixel lies there", view.name));
    }
}
