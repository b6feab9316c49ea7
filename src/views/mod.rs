//! The planner: which directions the outputs sample, and the fewest, tightest views that show them.
//!
//! `sight` maps the pixels of each output to directions, `samples` gathers them along lines, `fit` and `density`
//! find the opening and the resolution that a view with given axes needs (four samples at a time: `lanes`), `axes` and
//! `partition` choose axes, `alone` plans views that serve one output, `choose` compares the families of views by what `cost` says, `layout` and `atlas` size and place them,
//! `curved` gives outputs whose vertices are projected straight to their pixels a picture of their own,
//! `kept` has a cache remember what was chosen,
//! `cells` says what given cells cost, `idle` finds those that would be drawn for nothing, `survey` and `report` look at the result.
//!
//! Resolution at quality 1: a projector or a perspective output gets at least one texel per pixel
//! in every direction, everywhere; a domemaster gets its nominal resolution (diameter over aperture)
//! in every direction, everywhere, or that of its own pixels (`[views] resolution = "full"`).

pub mod arranging;
pub mod fitting;
pub mod placing;
pub mod reporting;
pub mod sampling;
use crate::views::arranging::cached;
pub use crate::views::arranging::cells::{CellCosts, with_cell_costs};
pub use crate::views::arranging::cost::cost;
use crate::views::placing::{idle, layout};
pub use crate::views::reporting::report::{OutputShare, Report, ViewReport, report};
pub use crate::views::reporting::survey::{Surveyed, Surveyor, survey};

use crate::cache::Cache;
use crate::error::{Error, ErrorKind, Result};
use crate::geom::{Frustum, PictureMap};
use crate::rig::Rig;
use crate::views::sampling::output_map::Sight;
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

impl Tile {
    /// How many texels it has.
    pub fn area(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// One picture of the program's world; a perspective one mostly.
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
    /// It is the picture of an output, pixel for pixel, to which vertices are projected by this map; `rotation` leads to
    /// its axes, and the openings stand for nothing.
    pub curved: Option<PictureMap>,
    /// How far to the right of the viewer's position it is seen from, metres.
    pub eye: f64,
}

/// What the planner is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Resolution of each output in pixels, in the rig's order; (0, 0) of one that is not shown, which gets no views.
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
    /// Width and height of the atlas in texels; [`ViewPlan::NO_ATLAS`]: each view has a picture of its own.
    pub atlas: (u32, u32),
    /// The flat panel: tile, and its rotation and opening as a view (`program_lens` is true).
    pub panel: Option<View>,
    /// The program's own picture.
    pub primary: Option<Tile>,
    /// Texels around the sampled part of each tile (none around those with `program_lens`).
    pub guard: u32,
    /// So many of these are there because outputs sample beside the exact place: so far beyond its part a view answers, too.
    pub reach: u32,
    /// Remarks for people: what was left out or scaled down, and why.
    pub notes: Vec<String>,
}

impl ViewPlan {
    /// The size of an atlas that is none.
    pub const NO_ATLAS: (u32, u32) = (0, 0);

    /// Width and height in texels of the picture in which `view` has its tile.
    pub fn picture_size(&self, view: &View) -> (u32, u32) {
        if self.atlas == Self::NO_ATLAS { (view.tile.width, view.tile.height) } else { self.atlas }
    }
}

/// Plans the views of `rig`: deterministic, and without a graphics API.
///
/// A rig with `passthrough` has no views. Every direction that an output shows at a pixel's
/// centre lies in `owned` of at least one view of `output_views[output]`, by a quarter of a texel
/// where views meet or end, and the bilinear footprint of every sample stays inside the tile.
///
/// # Errors
///
/// [`ErrorKind::InvalidArgument`] if one side of a size is 0 or the list of sizes has the wrong length;
/// [`ErrorKind::InvalidRig`] if `method` is [`Single`](crate::rig::ViewMethod::Single) and an output sees
/// too much for one perspective view; [`ErrorKind::Graphics`] if nothing fits into the atlas.
/// Where only the resolution must be reduced to fit, the plan says so in `notes`.
pub fn plan(rig: &Rig, request: &Request) -> Result<ViewPlan> {
    plan_with_reach(rig, request, 0, &Cache::none())
}

/// As [`plan`], for outputs that sample up to so many texels beside the exact place; `cache` may know what is chosen, or keeps it.
///
/// # Errors
/// As [`plan`].
pub fn plan_with_reach(rig: &Rig, request: &Request, reach: u32, cache: &Cache) -> Result<ViewPlan> {
    // A mirrored picture shows the same directions.
    let rig = &*rig.upright();
    let outputs: &[_] = if rig.passthrough { &[] } else { &rig.outputs };
    check(outputs.len(), rig.passthrough, request)?;
    let sights = sights(rig, outputs.len(), request)?;
    let mut arrangement = cached::arrange(rig, &sights, cache)?;
    loop {
        let plan = layout::place(rig, request, reach, &arrangement.views, &arrangement.notes)?;
        let Some(idle) = idle::find(&plan, &sights) else { return Ok(plan) };
        let view = arrangement.views.remove(idle);
        arrangement.notes.push(format!("no view {}: the centre of no pixel lies there", view.name));
    }
}

/// The maps of the first `outputs` outputs.
fn sights(rig: &Rig, outputs: usize, request: &Request) -> Result<Vec<Sight>> {
    let sizes = request.output_sizes.iter().take(outputs).enumerate();
    sizes.map(|(index, &size)| Sight::new(rig, index, size)).collect()
}

/// Whether the request makes sense for so many outputs.
fn check(outputs: usize, passthrough: bool, request: &Request) -> Result<()> {
    let invalid = |message: String| Err(Error::new(ErrorKind::InvalidArgument, message));
    if !passthrough && request.output_sizes.len() != outputs {
        return invalid(format!("{} output sizes were given for {outputs} outputs", request.output_sizes.len()));
    }
    if let Some(index) = request.output_sizes.iter().position(|size| (size.0 == 0) != (size.1 == 0)) {
        return invalid(format!("output {index} has no pixels"));
    }
    if (request.panel || request.primary) && (request.window.0 == 0 || request.window.1 == 0) {
        return invalid("the window has no pixels".to_owned());
    }
    Ok(())
}

#[cfg(test)]
pub(crate) mod tests;
