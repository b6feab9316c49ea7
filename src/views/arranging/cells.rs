//! Cost of given cells, for searches for better cells than those of a cube.

use crate::error::{Error, ErrorKind, Result};
use crate::rig::Rig;
use crate::views::arranging::choose::frames;
use crate::views::arranging::cost::PlannerOptions;
use crate::views::arranging::dedicated::own_view;
use crate::views::arranging::partition::{Task, diagram};
use crate::views::arranging::projected;
use crate::views::sampling::effort::Effort;
use crate::views::sampling::output_map;
use crate::views::sampling::samples::{COARSE, Samples};
use crate::views::view_plan::Request;
use glam::{DMat3, DVec3};

/// Cost of cells for the outputs of a rig that share views. Made by [`with_cell_costs`].
#[derive(Debug)]
pub struct CellCosts<'a> {
    task: Task<'a>,
    frames: Vec<DMat3>,
}

impl CellCosts<'_> {
    /// Returns the approximate number of texels of the views for the cells that these vectors
    /// define, as [`Views::cells`](crate::rig::Views::cells) does; infinite where a cell is too
    /// wide for a perspective view. The sum stops at the first cell with which it exceeds `limit`.
    pub fn texels(&self, vectors: &[DVec3], limit: f64) -> f64 {
        let mut sum = 0.0;
        for cell in diagram(vectors) {
            sum += self.task.texels(&cell);
            if sum > limit {
                break;
            }
        }
        sum
    }

    /// Returns the vectors of the cheapest cube's faces, without the faces that no output samples.
    pub fn cube(&self) -> Vec<DVec3> {
        self.task.best_vectors(&self.frames)
    }

    /// Returns the directions that the outputs show, as unit vectors in the viewer's axes.
    pub fn directions(&self) -> Vec<DVec3> {
        self.task.coarse.iter().flat_map(|samples| samples.iter()).map(|sample| sample.direction).collect()
    }
}

/// Calls `search` with the costs of cells for the outputs of `rig` that can share views. Returns
/// the result of `search`.
///
/// # Errors
///
/// [`ErrorKind::InvalidArgument`] as for [`plan`](crate::views::plan), and for a rig without
/// outputs that can share views.
pub fn with_cell_costs<R>(rig: &Rig, request: &Request, search: impl FnOnce(&CellCosts) -> R) -> Result<R> {
    let rig = &*rig.upright();
    request.check(rig.outputs.len(), rig.passthrough)?;
    let output_maps = output_map::all(rig, rig.outputs.len(), request)?;
    let shares = |index: usize| {
        projected::view(rig, index, output_maps[index].size).is_none()
            && own_view(&rig.outputs[index].kind, index, &output_maps[index], rig.views.method).is_none()
    };
    let mut effort = Effort::of_plan(rig);
    let shared: Vec<(usize, Samples)> = (0..output_maps.len())
        .filter(|&index| shares(index))
        .map(|index| (index, Samples::new(&output_maps[index], COARSE, &mut effort)))
        .filter(|(_, samples)| !samples.is_empty())
        .collect();
    if shared.is_empty() {
        return Err(Error::new(ErrorKind::InvalidArgument, "the rig has no outputs that share views"));
    }
    let (indices, samples): (Vec<usize>, Vec<&Samples>) =
        shared.iter().map(|(index, samples)| (*index, samples)).unzip();
    let task = Task::new(&PlannerOptions::of(rig), &samples, &samples);
    Ok(search(&CellCosts { task, frames: frames(rig, &indices, &samples) }))
}
