//! Layout of the views' pictures in memory.

use crate::correct::passes::output_pass::Plan;
use crate::views::{Tile, ViewPlan};

/// Arrangement of the views' pictures in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Arrangement {
    /// Tiles of one picture.
    #[default]
    Atlas,
    /// Layers of one image, in the views' order. All have the size of the largest view, since
    /// drawing to all layers at once (multiview) has one viewport. Smaller views are drawn with
    /// more than the planned resolution.
    Layers,
    /// One image for each view, as large as its tile.
    Images,
}

/// Size of an image that contains pictures of views.
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
    /// Returns the plan, which has an atlas, with its views in this arrangement. Only an atlas has
    /// room for the flat panel and for the program's own picture.
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

    /// Returns the images of a plan in this arrangement.
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
