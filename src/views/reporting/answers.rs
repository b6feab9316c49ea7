//! Search for the view that serves a direction of an output.

use crate::geom::ContentMap;
use crate::rig::Rig;
use crate::views::fitting::fit::sharpness;
use crate::views::sampling::cone::Cone;
use crate::views::sampling::output_map::OutputMap;
use crate::views::sampling::sample::Sample;
use crate::views::view_plan::{View, ViewPlan};
use glam::{DMat2, DVec2};

/// The views of one output.
pub(super) struct Answers<'a> {
    plan: &'a ViewPlan,
    cones: Vec<(usize, Cone)>,
    /// Index of the program's window, if it is the only view, and the map from a direction to a
    /// place in it.
    content: Option<(usize, ContentMap)>,
}

impl<'a> Answers<'a> {
    pub fn new(plan: &'a ViewPlan, rig: &Rig, output: usize) -> Self {
        let views = plan.output_views.get(output).map_or(&[][..], Vec::as_slice);
        let content = views.first().and_then(|&view| {
            let tile = plan.views[view].tile;
            Some((view, rig.content_map(output, (tile.width, tile.height))?))
        });
        let cones = views.iter().map(|&view| (view, Cone::of(&plan.views[view]))).collect();
        Self { plan, cones, content }
    }

    /// Returns the index of the view that a pixel samples.
    pub fn view(&self, sample: &Sample) -> Option<usize> {
        match &self.content {
            Some((view, map)) => map.place(sample.direction).map(|_| *view),
            None => self.cones.iter().find(|(_, cone)| cone.contains(sample.direction)).map(|(view, _)| *view),
        }
    }

    /// True if the plan has a view with this index.
    pub fn has(&self, view: usize) -> bool {
        view < self.plan.views.len()
    }

    /// Returns the texels per pixel in the direction with the fewest, if that is known. `pixel` is
    /// the sample's place in `map`.
    pub fn texels_per_pixel(&self, view: usize, sample: &Sample, pixel: DVec2, map: &OutputMap) -> Option<f64> {
        let answering = &self.plan.views[view];
        match &self.content {
            Some((_, content)) => content_sharpness(content, answering, pixel, map),
            None if answering.program_lens || answering.curved.is_some() => None,
            None => sharpness(answering.rotation, density(answering), sample),
        }
    }
}

/// Returns the same for content, by differences over a pixel; `None` at its rims.
fn content_sharpness(content: &ContentMap, window: &View, pixel: DVec2, map: &OutputMap) -> Option<f64> {
    let texels = DVec2::new(f64::from(window.tile.width), f64::from(window.tile.height));
    let place = |pixel| Some(texels * content.place(map.sample(pixel)?.direction)?);
    let step = |axis: DVec2| Some(place(pixel + 0.5 * axis)? - place(pixel - 0.5 * axis)?);
    let jacobian = DMat2::from_cols(step(DVec2::X)?, step(DVec2::Y)?);
    let squares = jacobian.x_axis.length_squared() + jacobian.y_axis.length_squared();
    let determinant = jacobian.determinant();
    // The lesser singular value: their squares add up to `squares`, their product is the
    // determinant.
    let root = (squares * squares - 4.0 * determinant * determinant).max(0.0).sqrt();
    Some((determinant.abs() / (0.5 * (squares + root)).sqrt()).abs()).filter(|value| value.is_finite())
}

/// Returns the texels of a view per unit of tangent, across and up.
fn density(view: &View) -> DVec2 {
    DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height))
        / DVec2::new(view.frustum.width(), view.frustum.height())
}
