//! The planner's steps in order: sample, arrange, place, remove views that no pixel samples.

use crate::cache::Cache;
use crate::error::Result;
use crate::geom::Frustum;
use crate::rig::Rig;
use crate::views::arranging::planned_view::Arrangement;
use crate::views::arranging::{cached, content, unseen};
use crate::views::placing::{idle, layout};
use crate::views::sampling::output_map::{self, OutputMap};
use crate::views::view_plan::{LEFT_OUT, Request, ViewPlan};
use glam::DVec2;
use std::borrow::Cow;

/// Plans the views of `rig`. The result is deterministic and needs no graphics API.
///
/// A rig with `passthrough` has no views. A rig with `content` has one view, the program's window.
/// For all other rigs, every direction that an output shows at a pixel's centre lies in `owned` of
/// at least one view of `output_views[output]`, by a quarter of a texel where views meet or end.
/// The bilinear footprint of every sample stays inside the tile.
///
/// # Errors
///
/// [`InvalidArgument`](crate::ErrorKind::InvalidArgument) if one side of a size is 0 or the list of
/// sizes has the wrong length; [`InvalidRig`](crate::ErrorKind::InvalidRig) if `method` is
/// [`Single`](crate::rig::ViewMethod::Single) and an output shows too much for one perspective
/// view; [`Graphics`](crate::ErrorKind::Graphics) if nothing fits into the atlas. Where only the
/// resolution must be reduced to fit, the plan says so in `notes`.
pub fn plan(rig: &Rig, request: &Request) -> Result<ViewPlan> {
    Planning::new(rig, request, 0, &Cache::none())?.place()
}

/// Views that are chosen and may still be widened.
#[derive(Debug)]
pub(crate) struct Planning<'a> {
    rig: Cow<'a, Rig>,
    request: &'a Request,
    sampling_margin: u32,
    output_maps: Vec<OutputMap>,
    arrangement: Arrangement,
}

impl<'a> Planning<'a> {
    /// Chooses the views of a rig whose outputs sample up to `sampling_margin` texels beside the
    /// exact place. Takes the choice from `cache`, or stores it there.
    ///
    /// # Errors
    /// As [`plan`].
    pub fn new(rig: &'a Rig, request: &'a Request, sampling_margin: u32, cache: &Cache) -> Result<Self> {
        // A mirrored picture shows the same directions.
        let rig = rig.upright();
        let outputs: &[_] = if rig.passthrough { &[] } else { &rig.outputs };
        request.check(outputs.len(), rig.passthrough)?;
        if rig.content.is_some() && !rig.passthrough {
            let views = vec![content::window(request, outputs.len())];
            let arrangement = Arrangement { views, ..Arrangement::default() };
            return Ok(Self { rig, request, sampling_margin, output_maps: Vec::new(), arrangement });
        }
        let output_maps = output_map::all(&rig, outputs.len(), request)?;
        let arrangement = cached::arrange(&rig, &output_maps, cache)?;
        Ok(Self { rig, request, sampling_margin, output_maps, arrangement })
    }

    /// Returns the views with their places in the atlas, without views that no pixel samples.
    ///
    /// # Errors
    /// [`Graphics`](crate::ErrorKind::Graphics) if nothing fits into the atlas.
    pub fn place(&mut self) -> Result<ViewPlan> {
        loop {
            let Arrangement { views, notes } = &self.arrangement;
            let plan = layout::place(&self.rig, self.request, self.sampling_margin, views, notes)?;
            // Content is one picture, whatever part of it is shown.
            let idle = if self.rig.content.is_some() { None } else { idle::find(&plan, &self.output_maps) };
            let Some(idle) = idle else { return Ok(plan) };
            let view = self.arrangement.views.remove(idle);
            self.arrangement.notes.push(format!("{LEFT_OUT}{}: no pixel's centre lies there", view.name));
        }
    }

    /// Widens a view of the latest plan so that it also serves the tangents in `extent`. Returns
    /// true if it did: views with an exact size stay unchanged.
    pub fn widen(&mut self, view: usize, extent: &Frustum) -> bool {
        let Some(view) = self.arrangement.views.get_mut(view).filter(|view| view.exact.is_none()) else { return false };
        view.fit.extent = view.fit.extent.union(extent);
        true
    }

    /// Adds views for directions that an output shows at pixel positions and that no view can be
    /// widened to show. Returns true if there are any.
    pub fn add(&mut self, output: usize, places: &[DVec2]) -> bool {
        let Some(output_map) = self.output_maps.get(output) else { return false };
        let added = unseen::views(&self.rig, (output, output_map), places, &self.arrangement.views);
        let any = !added.is_empty();
        self.arrangement.views.extend(added);
        any
    }
}
