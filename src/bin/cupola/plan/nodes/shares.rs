//! Shares of several nodes: the views and pixels that each draws and shows.

use cupola::Result;
use cupola::correct::{self, Plan};
use cupola::rig::{Place, Rig};
use cupola::views::Tile;
use std::collections::HashMap;

/// Views and pixels of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    pub outputs: usize,
    pub views: usize,
    /// Number of texels that it draws: those of these views that its outputs sample.
    pub texels: u64,
    /// Number of pixels of its outputs.
    pub pixels: u64,
    /// Number of bytes of views, window and stand-in image, 8 bytes for a texel with its depth.
    pub bytes: u64,
}

/// Shares of a rig's nodes.
pub struct Shares<'a> {
    rig: &'a Rig,
    plan: Plan,
    sizes: &'a [(u32, u32)],
    /// Shares by the outputs that are shown.
    known: HashMap<Vec<bool>, Share>,
}

impl<'a> Shares<'a> {
    pub fn new(rig: &'a Rig, plan: Plan, sizes: &'a [(u32, u32)]) -> Self {
        Self { rig, plan, sizes, known: HashMap::new() }
    }

    /// Shares of each of `count` nodes.
    pub fn of(&mut self, count: u32) -> Result<Vec<Share>> {
        let node = |number| {
            let rig = self.rig.clone().on_node(&Place { number, count, host: String::new() })?;
            let here = rig.outputs.iter().map(|output| output.here).collect::<Vec<bool>>();
            Ok(self.share(here))
        };
        (0..count).map(node).collect()
    }

    fn share(&mut self, here: Vec<bool>) -> Share {
        if let Some(share) = self.known.get(&here) {
            return *share;
        }
        let share = self.computed(&here);
        self.known.insert(here, share);
        share
    }

    fn computed(&mut self, here: &[bool]) -> Share {
        for (pass, here) in self.plan.passes.iter_mut().zip(here) {
            pass.here = *here;
        }
        let views = &self.plan.views;
        let shown = |index: &usize| here.get(*index).copied().unwrap_or(false);
        let sampled = |view: usize| {
            views.output_views.iter().enumerate().any(|(output, views)| shown(&output) && views.contains(&view))
        };
        let unsampled = correct::unsampled_areas(&self.plan);
        let drawn: Vec<usize> = (0..views.views.len()).filter(|view| sampled(*view)).collect();
        let texels = |view: &usize| {
            let hidden: u64 = unsampled.get(*view).map_or(0, |tiles| tiles.iter().map(Tile::area).sum());
            views.views[*view].tile.area().saturating_sub(hidden)
        };
        let tiles: u64 = drawn.iter().map(|view| views.views[*view].tile.area()).sum();
        let sizes = self.sizes.iter().enumerate().filter(|(index, _)| shown(index));
        let pixels = sizes.map(|(_, (width, height))| u64::from(*width) * u64::from(*height)).sum();
        Share {
            outputs: here.iter().filter(|here| **here).count(),
            views: drawn.len(),
            texels: drawn.iter().map(texels).sum(),
            pixels,
            bytes: 8 * tiles + 8 * pixels,
        }
    }
}
