//! Layout of the views' pictures in memory.

use crate::correct::passes::output_pass::Plan;
use crate::views::{Tile, ViewPlan};

/// Arrangement of the views' pictures in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Arrangement {
    /// Tiles of one picture.
    #[default]
    Atlas,
    /// As the layers of one image, in the views' order, all of the size of the largest: what is
    /// drawn to all of them at once (multiview) has one viewport. The smaller views are drawn at
    /// more than the planned resolution.
    Layers,
    /// As an image each, as large as its tile is.
    Images,
}

/// An image that holds pictures of views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageSize {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Number of layers; more than one only for [`Arrangement::Layers`].
    pub layers: u32,
}

impl Arrangement {
    /// The plan, which has an atlas, for views that lie so. Only an atlas has a place for the flat
    /// panel and for the program's own picture.
    pub fn arrange(self, mut plan: Plan) -> Plan {
        let views = &mut plan.views;
        if self == Self::Atlas {
            return plan;
        }
        (views.panel, views.primary) = (None, None);
        let widest = views.views.iter().map(|view| view.tile.width).max().unwrap_or(0);
        let highest = views.views.iter().map(|view| view.tile.height).max().unwrap_or(0);
        let layer = Tile { x: 0, y: 0, width: widest, height: highest };
        for view in &mut views.views {
            view.tile = if self == Self::Layers { layer } else { Tile { x: 0, y: 0, ..view.tile } };
        }
        views.atlas = if self == Self::Layers { (widest, highest) } else { ViewPlan::NO_ATLAS };
        plan
    }

    /// The images of a plan that was arranged so.
    pub fn images(self, plan: &Plan) -> Vec<ImageSize> {
        let size = |(width, height), layers| ImageSize { width, height, layers };
        let views = &plan.views;
        match self {
            Self::Atlas => vec![size(views.atlas, 1)],
            Self::Layers => vec![size(views.atlas, views.views.len() as u32)],
            Self::Images => views.views.iter().map(|view| size(views.picture_size(view), 1)).collect(),
        }
    }
}
