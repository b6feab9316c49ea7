//! Views of outputs whose vertices are projected directly to their pixels: the output's own
//! picture, pixel for pixel.

use crate::geom::{PictureLens, PictureMap, pose};
use crate::rig::{Output, OutputKind, Rig};
use crate::views::arranging::planned_view::PlannedView;
use crate::views::fitting::fit::Fit;
use crate::views::sampling::output_map::{UNIT_FRUSTUM, lens_rotation, viewer_rotation};
use glam::{DMat3, DVec2, DVec3};

/// Returns the view of an output of `size` pixels; `None` if its method or its kind does not
/// project vertices.
pub(in crate::views) fn view(rig: &Rig, index: usize, size: (u32, u32)) -> Option<PlannedView> {
    let output = &rig.outputs[index];
    let (rotation, map) = map(rig, output, size).filter(|_| output.method.projects_vertices())?;
    Some(PlannedView {
        name: String::new(),
        rotation,
        fit: Fit { extent: UNIT_FRUSTUM, density: 0.5 * pixels(size) },
        exact: Some(size),
        program_lens: false,
        curved: Some(map),
        eye: output.eye,
        outputs: vec![index],
    })
}

/// Returns the rotation viewer axes → lens axes, and the map of an output of `size` pixels on the
/// dome.
fn map(rig: &Rig, output: &Output, size: (u32, u32)) -> Option<(DMat3, PictureMap)> {
    let to_viewer = viewer_rotation(rig).transpose();
    let viewer = to_viewer * rig.eye(output).position / rig.dome.radius;
    match &output.kind {
        OutputKind::Domemaster { aperture, tilt } => {
            let to_lens = lens_rotation(*tilt).transpose();
            let pixels = pixels(size);
            let lens = PictureLens::Fisheye { aperture: *aperture, circle: pixels.min_element() / pixels, pixels };
            Some((to_lens, PictureMap { viewer: to_lens * viewer, position: DVec3::ZERO, lens }))
        }
        OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } => {
            let dome_to_lens = pose::rotation(*yaw, *pitch, *roll).transpose();
            let to_lens = dome_to_lens * viewer_rotation(rig);
            let position = dome_to_lens * *position / rig.dome.radius;
            Some((to_lens, PictureMap { viewer: to_lens * viewer, position, lens: PictureLens::Pinhole(*frustum) }))
        }
        _ => None,
    }
}

fn pixels((width, height): (u32, u32)) -> DVec2 {
    DVec2::new(f64::from(width), f64::from(height))
}
