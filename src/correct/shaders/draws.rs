//! The draw calls of a plan: which triangles with which constants.

use crate::correct::passes::facets::Facets;
use crate::correct::passes::output_pass::{OutputPass, Plan};
use crate::correct::plan::cover::uncovered;
use crate::correct::shaders::constants::Constants;
use crate::correct::shaders::uniforms::{constants, copies_texels, facet_corner, rectangle};
use crate::error::Result;
use crate::geom::Frustum;
use crate::geom::rectangle::PixelRect;
use crate::views::{Tile, View};
use glam::{DMat3, DVec3};

pub use crate::correct::shaders::uniforms::{FLOATS, SOURCE_FLOATS};

/// One draw call: triangles that share a shader.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// Constants that specialise the shader.
    pub constants: Constants,
    /// First index.
    pub first: u32,
    /// Number of indices, three for each triangle.
    pub count: u32,
    /// Views that the draw samples, as indices into the plan's views; empty for black.
    pub views: Vec<usize>,
    /// True if the batch shows its view 1:1. Texels are then copied if the target has the size of
    /// the output.
    pub nearest: bool,
}

/// The draw calls of some outputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawList {
    /// Draw calls of each output, in order.
    pub outputs: Vec<Vec<Draw>>,
    /// Vertices of all draws, [`FLOATS`] numbers each.
    pub vertices: Vec<f32>,
    /// Indices of the triangles' vertices.
    pub indices: Vec<u32>,
}

/// Order in memory of the rows of a picture with views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// The first row is the bottom one: OpenGL.
    FromBottom,
    /// The first row is the top one: Vulkan. A tile begins `atlas height − y − height` rows below
    /// the first.
    FromTop,
}

/// Returns the draws of `passes`, outputs of `plan`: one for the black pixels, and one for each
/// batch. `panel`: the flat panel is shown where the plan has one.
///
/// # Errors
/// [`crate::ErrorKind::Internal`] where the plan exceeds the limits of the shaders.
pub fn draws(plan: &Plan, passes: &[OutputPass], panel: bool, rows: Rows) -> Result<DrawList> {
    let shown = match rows {
        Rows::FromBottom => plan.clone(),
        Rows::FromTop => from_top(plan),
    };
    let mut list = DrawList::default();
    for pass in passes {
        let mut draws = Vec::with_capacity(pass.batches.len() + 1);
        let first_vertex = list.vertices.len();
        // Black comes first, since some triangles reach beyond the rectangles.
        let covered: Vec<PixelRect> = pass.filled().copied().collect();
        let black = uncovered(pass.size, &covered);
        if !black.is_empty() {
            draws.push(list.draw(Constants::black(), |list| list.add_rectangles(pass, &black)));
        }
        for batch in &pass.batches {
            let constants = constants(&shown, pass, batch, panel)?;
            // The panel is seldom 1:1 and shares the sampler.
            let nearest = copies_texels(plan, pass, batch) && !(panel && plan.views.panel.is_some());
            let base = constants.base();
            let draw = list.draw(constants, |list| match &batch.facets {
                Some(facets) => list.add_facets(pass, facets, base),
                None => list.add_rectangles(pass, &batch.rects),
            });
            draws.push(Draw { views: batch.views.clone(), nearest, ..draw });
        }
        list.mirror(first_vertex, pass);
        list.outputs.push(draws);
    }
    Ok(list)
}

impl DrawList {
    /// Returns the draw of the triangles that `add` adds.
    fn draw(&mut self, constants: Constants, add: impl FnOnce(&mut Self)) -> Draw {
        let first = self.indices.len() as u32;
        add(self);
        Draw { constants, first, count: self.indices.len() as u32 - first, views: Vec::new(), nearest: false }
    }

    /// Moves the vertices from `first` on to their places in the mirrored picture. Their source
    /// coordinates stay the same.
    fn mirror(&mut self, first: usize, pass: &OutputPass) {
        for vertex in self.vertices[first..].chunks_exact_mut(FLOATS) {
            if pass.flip.horizontal {
                vertex[0] = -vertex[0];
            }
            if pass.flip.vertical {
                vertex[1] = -vertex[1];
            }
        }
    }

    fn next_vertex(&self) -> u32 {
        (self.vertices.len() / FLOATS) as u32
    }

    fn add_rectangles(&mut self, pass: &OutputPass, rects: &[PixelRect]) {
        for rect in rects {
            let first = self.next_vertex();
            self.vertices.extend(rectangle(pass, rect).as_flattened());
            self.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
        }
    }

    fn add_facets(&mut self, pass: &OutputPass, facets: &Facets, base: DMat3) {
        let first = self.next_vertex();
        self.vertices.extend(facets.corners.iter().flat_map(|corner| facet_corner(pass, corner, base)));
        self.indices.extend(facets.triangles.as_flattened().iter().map(|corner| first + corner));
    }
}

/// Returns the plan for pictures whose first row is the top one. If the rows of a view's picture
/// are in the other order, the view is mirrored.
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
