//! Views for directions that the planner's samples missed and that no view can be widened to show.
//!
//! A cell without samples gets no view. At a flat angle to a mirror or a screen, the picture of an
//! output may be narrower than a step of the samples' grid. Pixels may then lie in such a cell.
//! They are found when passes are built.

use crate::rig::Rig;
use crate::views::arranging::choose::{MOST_TEXELS_PER_PIXEL, direction_name, free_name};
use crate::views::arranging::planned_view::PlannedView;
use crate::views::fitting::axes::{OrientedView, tightest};
use crate::views::fitting::fit::Patch;
use crate::views::sampling::output_map::OutputMap;
use crate::views::sampling::sample::Sample;
use glam::{DVec2, DVec3};

/// Returns views for the directions that `output` shows at pixel positions. `others`: the existing
/// views.
pub(in crate::views) fn views(
    rig: &Rig,
    (output, output_map): (usize, &OutputMap),
    places: &[DVec2],
    others: &[PlannedView],
) -> Vec<PlannedView> {
    let samples: Vec<Sample> = places.iter().filter_map(|place| output_map.sample_or_disc(*place)).collect();
    let quality = rig.views.quality;
    // One view for all, or one for each face of a cube: directions in the same face are near enough
    // to each other.
    let views = match oriented(&samples, quality) {
        Some(view) => vec![view],
        None => by_faces(&samples).iter().filter_map(|face| oriented(face, quality)).collect(),
    };
    let most = MOST_TEXELS_PER_PIXEL * quality * quality * places.len() as f64;
    let mut added: Vec<PlannedView> = Vec::new();
    for mut view in views {
        view.fit.density *= (most / view.fit.texels()).sqrt().min(1.0);
        let ahead = view.rotation.transpose() * DVec3::NEG_Z;
        let taken: Vec<PlannedView> = others.iter().chain(&added).cloned().collect();
        let name = free_name(&direction_name(ahead), &taken);
        added.push(PlannedView { name, outputs: vec![output], eye: rig.outputs[output].eye, ..view.into() });
    }
    added
}

fn oriented(samples: &[Sample], quality: f64) -> Option<OrientedView> {
    if samples.is_empty() {
        return None;
    }
    let patch = Patch::new(samples);
    tightest(&patch, &patch, quality)
}

/// Returns the samples in each face of a cube.
fn by_faces(samples: &[Sample]) -> [Vec<Sample>; 6] {
    let mut faces: [Vec<Sample>; 6] = Default::default();
    for sample in samples {
        let parts = sample.direction.to_array();
        let axis = (0..3).fold(0, |most, axis| if parts[axis].abs() > parts[most].abs() { axis } else { most });
        faces[2 * axis + usize::from(parts[axis] < 0.0)].push(*sample);
    }
    faces
}
