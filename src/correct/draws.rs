//! The draw calls of a plan: which rectangles with which constants.

use super::cover::uncovered;
use super::plan::{OutputPass, PixelRect, Plan};
use super::uniforms::{Constants, constants, copies_texels, rectangle};
use crate::error::Result;
use crate::geom::Frustum;
use crate::views::{Tile, View};
use glam::{DMat3, DVec3};

/// Floats per vertex: clip coordinates (x, y), the source's coordinates (x, y).
pub const FLOATS: usize = 4;

/// One draw call: triangles that share a shader.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// What specialises the shader.
    pub constants: Constants,
    /// First vertex.
    pub first: u32,
    /// Number of vertices.
    pub count: u32,
    /// The views that it samples, as numbers in the plan; empty for black.
    pub views: Vec<usize>,
    /// The batch shows its view 1:1: texels are taken as they are, where the target is as large as the output.
    pub nearest: bool,
}

/// The draw calls of some outputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawList {
    /// For each output, in order.
    pub outputs: Vec<Vec<Draw>>,
    /// The vertices of all, [`FLOATS`] numbers each.
    pub vertices: Vec<f32>,
}

/// In which order the rows of a picture with views are in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// The first row is the bottom one: OpenGL.
    FromBottom,
    /// The first row is the top one: Vulkan. A tile begins `atlas height − y − height` rows below the first.
    FromTop,
}

/// The draws of `passes`, outputs of `plan`: one for each batch, and one for what is black. `panel`: the
/// flat panel is shown where the plan has one.
///
/// # Errors
/// [`crate::ErrorKind::Internal`] where the plan exceeds what shaders take.
pub fn draws(plan: &Plan, passes: &[OutputPass], panel: bool, rows: Rows) -> Result<DrawList> {
    let shown = match rows {
        Rows::FromBottom => plan.clone(),
        Rows::FromTop => from_top(plan),
    };
    let mut list = DrawList::default();
    for pass in passes {
        let mut draws = Vec::with_capacity(pass.batches.len() + 1);
        for batch in &pass.batches {
            let constants = constants(&shown, pass, batch, panel)?;
            // The panel is seldom 1:1 and shares the sampler.
            let nearest = copies_texels(plan, pass, batch) && !(panel && plan.views.panel.is_some());
            draws.push(Draw {
                views: batch.views.clone(),
                nearest,
                ..draw(constants, pass, &batch.rects, &mut list.vertices)
            });
        }
        let covered: Vec<PixelRect> = pass.batches.iter().flat_map(|b| b.rects.iter().copied()).collect();
        let black = uncovered(pass.size, &covered);
        if !black.is_empty() {
            draws.push(draw(Constants::black(), pass, &black, &mut list.vertices));
        }
        list.outputs.push(draws);
    }
    Ok(list)
}

fn draw(constants: Constants, pass: &OutputPass, rects: &[PixelRect], vertices: &mut Vec<f32>) -> Draw {
    let first = (vertices.len() / FLOATS) as u32;
    for rect in rects {
        vertices.extend(rectangle(pass, rect).as_flattened());
    }
    Draw { constants, first, count: (vertices.len() / FLOATS) as u32 - first, views: Vec::new(), nearest: false }
}

/// The same plan over a picture whose first row is the top one: a view from whose picture the rows are
/// taken in the other order is the mirrored view.
pub fn from_top(plan: &Plan) -> Plan {
    let mut plan = plan.clone();
    let heights: Vec<u32> =
        plan.views.views.iter().chain(&plan.views.panel).map(|view| plan.views.picture_size(view).1).collect();
    let mirror = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
    let upside_down = |f: Frustum| Frustum { bottom: -f.top, top: -f.bottom, ..f };
    for (view, height) in plan.views.views.iter_mut().chain(&mut plan.views.panel).zip(heights) {
        let tile = Tile { y: height - view.tile.y - view.tile.height, ..view.tile };
        *view = View {
            rotation: mirror * view.rotation,
            frustum: upside_down(view.frustum),
            owned: upside_down(view.owned),
            tile,
            ..view.clone()
        };
    }
    plan
}
