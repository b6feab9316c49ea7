//! From an output of a rig to the coefficients of its map.

use super::plan::{Neighbour, ProjectorSource, Source};
use crate::geom::quadratic::{cap_row, row_at};
use crate::geom::{Fisheye, QuadraticForm, Sphere, pose};
use crate::rig::{Output, OutputKind, Rig};
use crate::views::sight::{lens_rotation, perspective_rays, pole, viewer_rotation};
use glam::{DMat3, DVec3};

/// The map of output `index` of `rig`, with every other projector as a neighbour if the output blends by overlap.
pub(super) fn of(rig: &Rig, index: usize) -> Source {
    let output = &rig.outputs[index];
    let to_viewer = viewer_rotation(rig).transpose();
    match &output.kind {
        OutputKind::Domemaster { aperture, tilt } => Source::Fisheye {
            aperture: *aperture,
            rotation: lens_rotation(*tilt),
            offset: -(to_viewer * rig.viewer.position) / rig.dome.radius,
        },
        OutputKind::Perspective { angles, frustum } => {
            Source::Perspective { matrix: perspective_rays(*angles, frustum.as_ref()) }
        }
        OutputKind::Projector { position, angles, frustum } => {
            let sphere = Sphere { center: DVec3::ZERO, radius: rig.dome.radius };
            let rays = pose::rotation(angles[0], angles[1], angles[2]) * frustum.rays();
            let seen_from = |eye: DVec3, target: DMat3| QuadraticForm::new(*position, rays, &sphere, eye, target);
            let neighbours =
                rig.outputs.iter().enumerate().filter(|(other, _)| output.blend.overlap && *other != index);
            Source::Projector(Box::new(ProjectorSource {
                direction: seen_from(rig.viewer.position, to_viewer),
                cap: (rig.dome.coverage < std::f64::consts::TAU)
                    .then(|| cap_row(*position, rays, &sphere, pole(rig), rig.dome.coverage)),
                // Turned about x by the tilt, the pole comes to lie on +y and the front on −z.
                dome_direction: seen_from(DVec3::ZERO, DMat3::from_rotation_x(rig.dome.tilt)),
                position: DMat3::from_rotation_x(rig.dome.tilt) * *position,
                neighbours: neighbours
                    .filter_map(|(other, neighbour)| neighbour_of(other, neighbour, &seen_from))
                    .collect(),
                ramp: output.blend.ramp,
            }))
        }
    }
}

/// `output` as a neighbour, if it is a projector.
fn neighbour_of(
    index: usize,
    output: &Output,
    seen_from: &impl Fn(DVec3, DMat3) -> QuadraticForm,
) -> Option<Neighbour> {
    let OutputKind::Projector { position, angles, frustum } = &output.kind else { return None };
    let picture = frustum.picture() * pose::rotation(angles[0], angles[1], angles[2]).transpose();
    Some(Neighbour { output: index, picture: seen_from(*position, picture), ramp: output.blend.ramp })
}

impl Source {
    /// The direction from the viewer at normalised coordinates, viewer axes, any length; `None`
    /// where the output shows nothing: what the shaders compute, in f64 (of a table, what the nearest pixel shows).
    pub fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        match self {
            Self::Fisheye { aperture, rotation, offset } => {
                Fisheye { aperture: *aperture }.direction(x, y).map(|lens| *rotation * lens + *offset)
            }
            Self::Projector(projector) => {
                let direction = projector.direction.evaluate(x, y)?;
                let on_screen =
                    projector.cap.is_none_or(|row| row_at(&row, projector.direction.discriminant(x, y), x, y) >= 0.0);
                on_screen.then_some(direction)
            }
            Self::Perspective { matrix } => Some(*matrix * DVec3::new(x, y, 1.0)),
            Self::Table(table) => table.nearest(0.5 * (1.0 + x), 0.5 * (1.0 - y)).map(|pixel| pixel.direction),
        }
    }

    /// Normalised coordinates of the pixel position `(column, row)`, from the top left with pixel
    /// centres at +½, in an output of `size` pixels.
    pub fn normalised(&self, size: (u32, u32), column: f64, row: f64) -> (f64, f64) {
        let (width, height) = (f64::from(size.0), f64::from(size.1));
        let (across, up) = match self {
            Self::Fisheye { .. } => (width.min(height), width.min(height)),
            _ => (width, height),
        };
        ((2.0 * column - width) / across, (height - 2.0 * row) / up)
    }
}
/// Viewer axes → dome axes turned so that the pole is +y and the front −z.
pub fn dome_axes(rig: &Rig) -> DMat3 {
    let viewer = &rig.viewer;
    DMat3::from_rotation_x(rig.dome.tilt) * crate::geom::pose::rotation(viewer.yaw, viewer.pitch, viewer.roll)
}
