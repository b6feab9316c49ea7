//! A rough correction for a rig that is being edited: its outputs over the views of the plan before.
//!
//! A plan of its own takes the new rig up to a second, and then its shaders have to be compiled.
//! Here the outputs are cut into cells of about a fortieth of their width, whose corners have exact
//! directions and weights, and the cells into triangles that lie in one view each. The triangles'
//! corners already have their places in the atlas. So one shader without numbers of the rig draws
//! all outputs of all rigs, and only its vertices change.
//!
//! Between the corners of pictures up to 640 pixels wide, directions are less than 0.6 pixels off,
//! and weights less than 0.12 at the corners of ramps (measured by `tests`). Pixels whose directions
//! no view shows are black.

mod cells;
mod pieces;
#[cfg(test)]
mod tests;

use crate::correct::over;
use crate::correct::passes::black::BlackPicture;
use crate::correct::passes::facets::Facets;
use crate::correct::passes::mask;
use crate::correct::passes::output_pass::{Batch, OutputPass, Plan};
use crate::correct::passes::source::Source;
use crate::correct::passes::table::Table;
use crate::correct::rough::pieces::Opening;
use crate::correct::sources::output_source;
use crate::correct::sources::surface_sample::SurfaceSampler;
use crate::geom::rectangle::PixelRect;
use crate::rig::{Output, Rig};
use crate::views::Request;
use std::sync::Arc;

/// Returns passes for `rig` over the views of `plan`, which was made for another rig and for
/// `request`. `drawn`: views that the program draws, one bit for each. The outputs are the same in
/// number, order and eyes.
///
/// `None` if these views cannot serve: some are no perspective views, or the window is content. Also
/// if a file of the rig cannot be read. The plan for the rig itself then finds the reason.
pub fn plan(rig: &Rig, request: &Request, plan: &Plan, drawn: u64) -> Option<Plan> {
    if !over::is_served(rig, plan) {
        return None;
    }
    let sizes: Vec<_> = request.output_sizes.iter().map(|&(width, height)| (width.max(1), height.max(1))).collect();
    let upright = rig.upright();
    let passes = (0..rig.outputs.len()).map(|index| {
        let facets = match request.output_sizes[index] {
            (0, 0) => Vec::new(),
            _ => {
                let views = over::views_of(plan, index, rig.outputs[index].eye, drawn);
                let openings: Vec<_> = views.into_iter().map(|view| Opening::of(&plan.views, view)).collect();
                let sampler = SurfaceSampler::new(&upright, index, &sizes).ok()?;
                pieces::in_views(&cells::triangles(&sampler), &openings)
            }
        };
        pass(rig, index, sizes[index], facets)
    });
    Some(Plan { passes: passes.collect::<Option<_>>()?, views: plan.views.clone() })
}

/// Returns the pass of an output whose pixels show the triangles of some views.
fn pass(rig: &Rig, index: usize, size: (u32, u32), facets: Vec<(usize, Facets)>) -> Option<OutputPass> {
    let output: &Output = &rig.outputs[index];
    let mask = output.mask.as_deref().map(mask::load).transpose().ok()?;
    let batch = |(view, facets): (usize, Facets)| Batch {
        views: vec![view],
        neighbours: Vec::new(),
        edge: false,
        masked: mask.is_some(),
        rects: vec![PixelRect { x: 0, y: 0, width: size.0, height: size.1 }],
        facets: Some(Arc::new(facets)),
    };
    Some(OutputPass {
        name: output.name.clone(),
        here: output.here,
        size,
        batches: facets.into_iter().map(batch).collect(),
        // Triangles do not know how many pictures meet at their pixels.
        lift: 0.0,
        ramps: Vec::new(),
        // It is not read, and has no places that the cleared views could be compared with.
        source: Source::Table(Arc::new(Table::new((0, 0), |_, _| None))),
        mask: mask.map(|mask| mask.flipped(output.flip)),
        dome_rotation: output_source::dome_axes(rig),
        filter: rig.views.filter,
        gamma: output.blend.gamma,
        transfer: output.blend.transfer.clone(),
        black_level: output.blend.black_level,
        black: output.black.as_deref().map(|black| BlackPicture::of(black, &output.blend, output.flip)),
        dither: output.blend.dither.map_or(0.0, |bits| 1.0 / (f64::from(bits).exp2() - 1.0)),
        flip: output.flip,
        content: None,
    })
}
