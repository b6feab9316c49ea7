//! The planner: which directions the outputs sample, and the fewest, tightest views that show them.

use crate::error::Result;
use crate::geom::Frustum;
use crate::rig::Rig;
use glam::DMat3;

/// A rectangle of the atlas in texels, from the bottom left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// One perspective picture of the program's world.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Name for people: `front`, `left`, `projector-3` …
    pub name: String,
    /// Axes of the viewer → axes of the view.
    pub rotation: DMat3,
    /// Opening of the whole tile, guard included.
    pub frustum: Frustum,
    /// The part of the opening that outputs sample: what this view answers for.
    pub owned: Frustum,
    /// Where it is in the atlas.
    pub tile: Tile,
    /// Drawn with the program's own projection, whatever `frustum` says.
    pub program_lens: bool,
}

/// What the planner is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Resolution of each output in pixels, in the rig's order.
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

/// The views and where they are.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewPlan {
    /// The views; where two show a direction, the first one answers.
    pub views: Vec<View>,
    /// For each output the indices of the views that it samples.
    pub output_views: Vec<Vec<usize>>,
    /// Width and height of the atlas in texels.
    pub atlas: (u32, u32),
    /// The flat panel: tile, and its rotation and opening as a view (`program_lens` is true).
    pub panel: Option<View>,
    /// The program's own picture.
    pub primary: Option<Tile>,
    /// Texels around the sampled part of each tile.
    pub guard: u32,
}

/// Plans the views of `rig`.
pub fn plan(rig: &Rig, request: &Request) -> Result<ViewPlan> {
    let _ = (rig, request);
    Err(crate::Error::new(crate::ErrorKind::Internal, "not written yet"))
}
