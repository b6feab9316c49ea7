//! From an output of a rig to the coefficients of its map.

use super::plan::{Neighbour, ProjectorSource, Source};
use super::rounding;
use super::shown::Shown;
use super::table;
use crate::blend::Border;
use crate::error::Result;
use crate::geom::fisheye::RadialForm;
use crate::geom::quadratic::{cap_row, row_at, sphere_is_ahead};
use crate::geom::{Fisheye, Panorama, QuadraticForm, Sphere, pose};
use crate::rig::{Method, Output, OutputKind, Rig};
use crate::views::sight::{lens_rotation, perspective_rays, pole, viewer_rotation};
use glam::{DMat3, DVec2, DVec3};
use std::sync::Arc;

/// The map of output `index` of `rig`, whose outputs have `sizes` pixels: a coarse table where its method asks for one,
/// else the closed form where there is one, otherwise a table of all pixels.
///
/// # Errors
/// Those of [`Shown::new`].
pub(super) fn of(rig: &Rig, index: usize, sizes: &[(u32, u32)]) -> Result<Source> {
    let shown = || Shown::new(rig, index, sizes);
    let size = sizes.get(index).copied().unwrap_or_default();
    let exact = |source: &Source| is_exact(rig, index) && is_well_conditioned(source, size);
    let table = match (rig.outputs[index].method, closed_form(rig, index).filter(exact)) {
        (Method::Table { max_error }, _) => table::coarse(&shown()?, max_error),
        (_, Some(source)) => return Ok(source),
        _ => shown()?.table(),
    };
    Ok(Source::Table(Arc::new(table)))
}

/// Whether the formula of an output is right everywhere, and knows all that its weights depend on.
///
/// It knows no screen but the dome. It is not right in two cases outside the dome: for a projector that looks partly away from it, whose rays would meet
/// it backwards, and beside a neighbour there, of whose light the near side of the dome keeps its share
/// although none arrives. Nor does it know a neighbour's lens that is no pinhole, or its mirror.
fn is_exact(rig: &Rig, index: usize) -> bool {
    let output = &rig.outputs[index];
    if matches!(output.kind, OutputKind::Perspective { .. }) {
        return true;
    }
    if rig.screen.is_some() {
        return false;
    }
    let Some(pinhole) = Pinhole::of(&output.kind) else { return true };
    let sphere = Sphere { center: DVec3::ZERO, radius: rig.dome.radius };
    let mut others = rig.outputs.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, other)| &other.kind);
    let known = |other: &OutputKind| match Pinhole::of(other) {
        Some(other) => sphere.contains(other.position),
        None => !other.is_projector(),
    };
    sphere_is_ahead(pinhole.position, pinhole.rays, &sphere) && (!output.blend.overlap || others.all(known))
}

/// Whether f32 is enough for the formula of a picture of `size` pixels.
///
/// Not for a projector whose light passes close to the viewer, for whom the screen there is the small difference
/// of two places, nor where rays graze the screen and the root of a difference decides.
fn is_well_conditioned(source: &Source, size: (u32, u32)) -> bool {
    let Source::Projector(projector) = source else { return true };
    let form = &projector.direction;
    rounding::excess(form, projector.cap.as_ref(), size, |x, y| rounding::of_form(form, x, y)) <= 1.0
}

/// A projector whose rays are linear in the pixel.
struct Pinhole {
    position: DVec3,
    /// Pixel `(x, y, 1)` → ray in dome axes.
    rays: DMat3,
}

impl Pinhole {
    /// `None` for what is no projector, or has another lens, a mirror or weights by area.
    fn of(kind: &OutputKind) -> Option<Self> {
        match kind {
            OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } => {
                Some(Self { position: *position, rays: pose::rotation(*yaw, *pitch, *roll) * frustum.rays() })
            }
            OutputKind::Optics { optics, even_light: 0.0 } if optics.mirror.is_none() => {
                Some(Self { position: optics.pose.position, rays: optics.pose.rotation * optics.lens.linear_rays()? })
            }
            _ => None,
        }
    }
}

/// The formula of an output, with every other projector as a neighbour if the output blends by overlap; `None`
/// for lenses that are no pinholes, and for mirrors.
fn closed_form(rig: &Rig, index: usize) -> Option<Source> {
    let output = &rig.outputs[index];
    let to_viewer = viewer_rotation(rig).transpose();
    let eye = rig.eye(output).position;
    Some(match &output.kind {
        OutputKind::Mesh(_) => return None,
        OutputKind::Domemaster { aperture, tilt } => Source::Fisheye {
            aperture: *aperture,
            rotation: lens_rotation(*tilt),
            offset: -(to_viewer * eye) / rig.dome.radius,
        },
        OutputKind::Panorama { panorama, angles: [yaw, pitch, roll] } => {
            // Some measured curves are too wild for the shaders' polynomials.
            if matches!(panorama, Panorama::Fisheye(lens) if RadialForm::of(lens).is_none()) {
                return None;
            }
            Source::Panorama {
                panorama: panorama.clone(),
                rotation: pose::rotation(*yaw, *pitch, *roll),
                offset: -(to_viewer * eye) / rig.dome.radius,
            }
        }
        OutputKind::Perspective { angles, frustum } => {
            Source::Perspective { matrix: perspective_rays(*angles, frustum.as_ref()) }
        }
        OutputKind::Projector { .. } | OutputKind::Optics { .. } => {
            let Pinhole { position, rays } = Pinhole::of(&output.kind)?;
            let sphere = Sphere { center: DVec3::ZERO, radius: rig.dome.radius };
            let seen_from = |eye: DVec3, target: DMat3| QuadraticForm::new(position, rays, &sphere, eye, target);
            let neighbours =
                rig.outputs.iter().enumerate().filter(|(other, _)| output.blend.overlap && *other != index);
            Source::Projector(Box::new(ProjectorSource {
                direction: seen_from(eye, to_viewer),
                cap: (rig.dome.coverage < std::f64::consts::TAU)
                    .then(|| cap_row(position, rays, &sphere, pole(rig), rig.dome.coverage)),
                // Turned about x by the tilt, the pole comes to lie on +y and the front on −z.
                dome_direction: seen_from(DVec3::ZERO, DMat3::from_rotation_x(rig.dome.tilt)),
                position: DMat3::from_rotation_x(rig.dome.tilt) * position,
                neighbours: neighbours
                    .filter_map(|(other, neighbour)| neighbour_of(other, neighbour, &seen_from))
                    .collect(),
                border: Border::of(&output.blend),
            }))
        }
    })
}

/// `output` as a neighbour, if it is a projector.
fn neighbour_of(
    index: usize,
    output: &Output,
    seen_from: &impl Fn(DVec3, DMat3) -> QuadraticForm,
) -> Option<Neighbour> {
    let Pinhole { position, rays } = Pinhole::of(&output.kind)?;
    let border = Border::of(&output.blend);
    Some(Neighbour { output: index, picture: seen_from(position, rays.inverse()), border })
}

impl Source {
    /// The direction from the viewer at normalised coordinates, viewer axes, any length; `None`
    /// where the output shows nothing: what the shaders compute, in f64 (of a table of all pixels, what the nearest one shows).
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
            Self::Panorama { panorama, rotation, offset } => {
                let direction = match panorama {
                    Panorama::Fisheye(lens) => lens.direction(DVec2::new(x, y)),
                    _ => panorama.direction(DVec2::new(x, y), 1.0),
                };
                direction.map(|direction| *rotation * direction + *offset)
            }
            Self::Perspective { matrix } => Some(*matrix * DVec3::new(x, y, 1.0)),
            Self::Table(table) => table.at(0.5 * (1.0 + x), 0.5 * (1.0 - y)).map(|pixel| pixel.direction),
        }
    }

    /// Normalised coordinates of the pixel position `(column, row)`, from the top left with pixel
    /// centres at +½, in an output of `size` pixels.
    pub fn normalised(&self, size: (u32, u32), column: f64, row: f64) -> (f64, f64) {
        let (width, height) = (f64::from(size.0), f64::from(size.1));
        let (across, up) = if self.is_circular() { (width.min(height), width.min(height)) } else { (width, height) };
        ((2.0 * column - width) / across, (height - 2.0 * row) / up)
    }

    /// Whether the picture is a circle inscribed in the output, and normalised coordinates are units of its radius.
    pub fn is_circular(&self) -> bool {
        match self {
            Self::Fisheye { .. } => true,
            Self::Panorama { panorama, .. } => panorama.is_circular(),
            _ => false,
        }
    }
}
/// Viewer axes → dome axes turned so that the pole is +y and the front −z.
pub fn dome_axes(rig: &Rig) -> DMat3 {
    let viewer = &rig.viewer;
    DMat3::from_rotation_x(rig.dome.tilt) * crate::geom::pose::rotation(viewer.yaw, viewer.pitch, viewer.roll)
}
