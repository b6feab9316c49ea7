//! Types of the planner's input and result: request, views, tiles, plan.

use crate::error::{Error, ErrorKind, Result};
use crate::geom::{Frustum, PictureMap};
use glam::DMat3;

/// A rectangle of the atlas in texels, from the bottom left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Tile {
    /// Left edge.
    pub x: u32,
    /// Bottom edge.
    pub y: u32,
    /// Width.
    pub width: u32,
    /// Height.
    pub height: u32,
}

impl Tile {
    /// Returns the number of texels.
    pub fn area(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// One picture of the program's world, mostly in perspective.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct View {
    /// Name in messages: `front`, `left`, `projector-3` …
    pub name: String,
    /// Axes of the viewer → axes of the view.
    pub rotation: DMat3,
    /// Opening of the whole tile, guard included.
    pub frustum: Frustum,
    /// Part of the opening that outputs sample.
    pub owned: Frustum,
    /// Tile in the atlas.
    pub tile: Tile,
    /// True if the view is drawn with the program's own projection, whatever `frustum` is.
    pub program_lens: bool,
    /// Map by which vertices are projected, if the view is the picture of an output, pixel for
    /// pixel. `rotation` then leads to the axes of this map, and the openings have no meaning.
    pub curved: Option<PictureMap>,
    /// Distance of the eye to the right of the viewer's position, metres.
    pub eye: f64,
}

/// Input of the planner beside the rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Resolution of each output in pixels, in the rig's order; (0, 0) for an output that is not
    /// shown, which gets no views.
    pub output_sizes: Vec<(u32, u32)>,
    /// Size of the program's window in pixels.
    pub window: (u32, u32),
    /// Reserve a tile for flat drawing, of the window's size.
    pub panel: bool,
    /// Reserve a tile for the program's own picture, of the window's size, at the atlas origin.
    pub primary: bool,
    /// Greatest width and height of the atlas.
    pub max_atlas: u32,
}

/// The views and their places.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewPlan {
    /// The views. If two show a direction, the first one is sampled.
    pub views: Vec<View>,
    /// For each output, the indices of the views that it samples.
    pub output_views: Vec<Vec<usize>>,
    /// Width and height of the atlas in texels; [`ViewPlan::NO_ATLAS`] if each view has its own
    /// picture.
    pub atlas: (u32, u32),
    /// The flat panel: tile, and its rotation and opening as a view (`program_lens` is true).
    pub panel: Option<View>,
    /// The program's own picture.
    pub primary: Option<Tile>,
    /// Texels around the sampled part of each tile (none around those with `program_lens`).
    pub guard: u32,
    /// Part of the guard for outputs whose sampling is approximate: views stay valid this far
    /// beyond their part.
    pub sampling_margin: u32,
    /// Remarks for the user: what was left out or scaled down, and why.
    pub notes: Vec<String>,
}

/// Beginning of notes about directions that get no view because no output shows them.
pub(crate) const LEFT_OUT: &str = "no view ";

impl ViewPlan {
    /// Returns the notes without those about directions that no output shows.
    pub fn remarks(&self) -> impl Iterator<Item = &str> {
        self.notes.iter().map(String::as_str).filter(|note| !note.starts_with(LEFT_OUT))
    }

    /// Size of the atlas if there is none.
    pub const NO_ATLAS: (u32, u32) = (0, 0);

    /// Returns width and height in texels of the picture in which `view` has its tile.
    pub fn picture_size(&self, view: &View) -> (u32, u32) {
        if self.atlas == Self::NO_ATLAS { (view.tile.width, view.tile.height) } else { self.atlas }
    }
}

impl Request {
    /// Returns an error where the request does not fit `outputs` outputs.
    pub(in crate::views) fn check(&self, outputs: usize, passthrough: bool) -> Result<()> {
        let invalid = |message: String| Err(Error::new(ErrorKind::InvalidArgument, message));
        if !passthrough && self.output_sizes.len() != outputs {
            return invalid(format!("{} output sizes were given for {outputs} outputs", self.output_sizes.len()));
        }
        if let Some(index) = self.output_sizes.iter().position(|size| (size.0 == 0) != (size.1 == 0)) {
            let (width, height) = self.output_sizes[index];
            return invalid(format!(
                "output {index} has {width} × {height} pixels; use a larger window, or fewer outputs"
            ));
        }
        if (self.panel || self.primary) && (self.window.0 == 0 || self.window.1 == 0) {
            return invalid("the window has no pixels".to_owned());
        }
        Ok(())
    }
}
