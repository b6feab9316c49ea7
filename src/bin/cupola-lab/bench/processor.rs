//! Correction on the processor, without a graphics API: the exact map in f64 and bilinear samples.

use super::quality::in_rows;
use cupola::correct::Plan;
use cupola::views::View;
use glam::{DVec2, DVec3};

/// A plan and the atlas that it corrects.
pub struct Processor {
    plan: Plan,
    /// Grey values of the atlas, the first row at the bottom.
    atlas: Vec<u8>,
}

impl Processor {
    /// The correction of the first output of `plan`, with the texels of its atlas.
    pub fn new(plan: &Plan, atlas: &[u32]) -> Self {
        Self { plan: plan.clone(), atlas: atlas.iter().map(|texel| texel.to_le_bytes()[0]).collect() }
    }

    /// The corrected picture, grey, row by row from the top.
    pub fn picture(&self) -> Vec<u8> {
        let (width, height) = self.plan.passes[0].size;
        in_rows(height, |y| (0..width).map(|x| self.direction(x, y).map_or(0, |seen| self.sample(seen))).collect())
    }

    /// The direction of each pixel, row by row from the top.
    pub fn directions(&self) -> Vec<Option<DVec3>> {
        let (width, height) = self.plan.passes[0].size;
        in_rows(height, |y| (0..width).map(|x| self.direction(x, y)).collect())
    }

    fn direction(&self, x: u32, y: u32) -> Option<DVec3> {
        let pass = &self.plan.passes[0];
        let (x, y) = pass.source.normalised(pass.size, f64::from(x) + 0.5, f64::from(y) + 0.5);
        pass.source.direction(x, y)
    }

    fn sample(&self, direction: DVec3) -> u8 {
        let views = self.plan.views.output_views[0].iter().map(|&index| &self.plan.views.views[index]);
        let found = views.filter_map(|view| Some((view, tangent(view, direction)?)));
        let mut last = 0;
        for (view, at) in found {
            last = self.bilinear(view, at);
            if view.owned.contains(at.x, at.y) {
                return last;
            }
        }
        last
    }

    fn bilinear(&self, view: &View, at: DVec2) -> u8 {
        let (tile, frustum) = (view.tile, view.frustum);
        let part = (at - DVec2::new(frustum.left, frustum.bottom)) / DVec2::new(frustum.width(), frustum.height());
        let place = part * DVec2::new(f64::from(tile.width), f64::from(tile.height)) - 0.5;
        let limit = DVec2::new(f64::from(tile.width) - 1.001, f64::from(tile.height) - 1.001);
        let place = place.clamp(DVec2::ZERO, limit.max(DVec2::ZERO));
        let (first, part) = (place.floor(), place.fract());
        let start = (tile.y as usize + first.y as usize) * self.plan.views.atlas.0 as usize
            + tile.x as usize
            + first.x as usize;
        let texel = |offset: usize| f64::from(self.atlas.get(start + offset).copied().unwrap_or_default());
        let row = |offset: usize| texel(offset) * (1.0 - part.x) + texel(offset + 1) * part.x;
        (row(0) * (1.0 - part.y) + row(self.plan.views.atlas.0 as usize) * part.y).round() as u8
    }
}

/// Position of a direction in a view, in tangents; `None` if it is behind the view.
fn tangent(view: &View, direction: DVec3) -> Option<DVec2> {
    let local = view.rotation * direction;
    (local.z < 0.0).then(|| local.truncate() / -local.z)
}
