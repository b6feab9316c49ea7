//! From an output of a rig to the coefficients of its map.

use crate::blend::EdgeWeight;
use crate::cache::Cache;
use crate::correct::passes::optics::{Light, OpticsSource};
use crate::correct::passes::source::{EvaluationMethod, Neighbour, ProjectorSource, Source};
use crate::correct::sources::surface_sample::SurfaceSampler;
use crate::correct::sources::{table_cached, table_coarse};
use crate::error::Result;
use crate::geom::lenses::equidistant::RadialForm;
use crate::geom::lenses::pinhole_rays::RimForms;
use crate::geom::screen::{ClosedForm, ClosedSurface, Shape};
use crate::geom::{Optics, Panorama, PinholeRays, Quadric, Screen, Sphere, pose};
use crate::rig::{Method, Output, OutputKind, Rig};
use crate::views::sampling::output_map::{lens_rotation, perspective_rays, viewer_rotation};
use glam::{DAffine3, DMat3, DVec3};
use std::sync::Arc;

/// Returns the map of output `index` of `rig`, whose outputs have `sizes` pixels: a coarse table if
/// its method requests one, otherwise the closed form if there is one, otherwise a table of all
/// pixels. Tables are taken from `cache`, or stored there.
///
/// # Errors
/// Those of [`SurfaceSampler::new`].
pub(in crate::correct) fn of(rig: &Rig, index: usize, sizes: &[(u32, u32)], cache: &Cache) -> Result<Source> {
    let shown = || SurfaceSampler::new(rig, index, sizes);
    let size = sizes.get(index).copied().unwrap_or_default();
    let table = match (rig.outputs[index].method, closed_form(rig, index, size)) {
        (Method::Table { max_error }, _) => {
            table_cached::cached(rig, index, sizes, cache, || Ok(table_coarse::coarse(&shown()?, max_error)))
        }
        (_, Some(source)) => return Ok(source),
        _ => table_cached::cached(rig, index, sizes, cache, || Ok(shown()?.table())),
    };
    Ok(Source::Table(Arc::new(table?)))
}

/// A projector whose rays are linear in the pixel.
struct Pinhole {
    position: DVec3,
    /// Pixel `(x, y, 1)` → ray in dome axes.
    rays: DMat3,
}

impl Pinhole {
    /// Returns `None` for outputs that are no projectors, or have another lens, a mirror or evened
    /// light.
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

/// Returns the formula of an output of `size` pixels, if there is one that is valid everywhere,
/// exact enough in f32, and includes everything on which its weights depend.
fn closed_form(rig: &Rig, index: usize, size: (u32, u32)) -> Option<Source> {
    let output = &rig.outputs[index];
    let to_viewer = viewer_rotation(rig).transpose();
    let eye = rig.eye(output).position;
    match &output.kind {
        OutputKind::Mesh(_) => None,
        OutputKind::Domemaster { aperture, tilt } => {
            let offset = offset_of_eye(rig, eye)?;
            let pixel = aperture / f64::from(size.0.min(size.1).max(1));
            (offset == DVec3::ZERO || are_told_apart(pixel, offset)).then(|| Source::Fisheye {
                aperture: *aperture,
                rotation: lens_rotation(*tilt),
                offset,
            })
        }
        OutputKind::Panorama { panorama, angles: [yaw, pitch, roll] } => {
            let offset = offset_of_eye(rig, eye)?;
            // The shaders' polynomials do not fit some measured curves.
            let has_formula = !matches!(panorama, Panorama::Fisheye(lens) if RadialForm::of(lens).is_none());
            // Small angles from the axis keep all their digits; those from the horizon do not.
            let exact = offset == DVec3::ZERO && panorama.is_circular() || are_told_apart(panorama.pixel(size), offset);
            let rotation = pose::rotation(*yaw, *pitch, *roll);
            (has_formula && exact).then(|| Source::Panorama { panorama: panorama.clone(), rotation, offset })
        }
        OutputKind::Perspective { angles, frustum } => {
            Some(Source::Perspective { matrix: perspective_rays(*angles, frustum.as_ref()) })
        }
        OutputKind::Projector { .. } | OutputKind::Optics { .. } => {
            let pinhole = projector(rig, index, eye, to_viewer).and_then(|source| source.settled(size));
            match (pinhole, &output.kind) {
                (Some(source), _) => Some(Source::Projector(Box::new(source))),
                (None, OutputKind::Optics { optics, even_light: 0.0 }) => {
                    let source = lens(rig, index, optics, size)?.settled(size)?;
                    Some(Source::Optics(Box::new(source)))
                }
                _ => None,
            }
        }
    }
}

/// Returns the vector that is added to a unit direction from the dome's centre for an eye
/// elsewhere; `None` for screens where no such vector exists.
fn offset_of_eye(rig: &Rig, eye: DVec3) -> Option<DVec3> {
    match &rig.screen {
        None => Some(-(viewer_rotation(rig).transpose() * eye) / rig.dome.radius),
        // From inside, every direction meets the surface, and an eye at the centre sees the point
        // in that direction.
        Some(Screen { pose, shape: Shape::Ellipsoid(ellipsoid) }) => {
            let inside = Quadric::ellipsoid(ellipsoid.radii).contains(pose.point_to_local(DVec3::ZERO), WELL_INSIDE);
            (inside && eye == DVec3::ZERO).then_some(DVec3::ZERO)
        }
        Some(_) => None,
    }
}

/// Least angle, radians, between directions that a unit vector in f32 plus an offset distinguishes
/// safely. Each direction is rounded to 6e-8. An eye near the screen sees this error enlarged by
/// the part of the radius that is left.
const TOLD_APART: f64 = 3e-7;

/// True if f32 distinguishes neighbouring pixels, `pixel` radians wide, of a picture of directions.
fn are_told_apart(pixel: f64, offset: DVec3) -> bool {
    pixel * (1.0 - offset.length()) >= TOLD_APART
}

/// A dome's centre within this part of the way from a screen's centre to the screen is inside,
/// however it is rounded.
const WELL_INSIDE: f64 = 0.999;

/// Returns the formula of a pinhole; all other pinholes are neighbours if it blends by overlap.
/// `None` for other lenses, for mirrors, for screens without a formula, and where
///
/// - the projector stands outside of the surface and looks partly away from it: its rays would meet
///   the surface backwards;
/// - a neighbour stands outside: the formula would give it light on the far side;
/// - a neighbour has another lens, or a mirror.
fn projector(rig: &Rig, index: usize, eye: DVec3, to_viewer: DMat3) -> Option<ProjectorSource> {
    let output = &rig.outputs[index];
    let Screen { pose, shape } = rig.surface();
    let ClosedForm { middle, surface, bounds } = shape.closed_form()?;
    let to_surface = |point: DVec3| pose.point_to_local(point) - middle;
    let from_surface = pose.rotation;
    let Pinhole { position, rays } = Pinhole::of(&output.kind)?;
    let pinhole = PinholeRays { origin: to_surface(position), rays: from_surface.transpose() * rays, surface };
    let others = rig.outputs.iter().enumerate().filter(|(other, _)| output.blend.overlap && *other != index);
    let neighbour = |(output, other): (usize, &Output)| {
        let Some(Pinhole { position, rays }) = Pinhole::of(&other.kind) else {
            return other.kind.is_projector().then_some(None);
        };
        let position = to_surface(position);
        let lights_all = match &surface {
            ClosedSurface::Quadric(quadric) => quadric.contains(position, 1.0),
            ClosedSurface::Plane => true,
        };
        let picture = || pinhole.seen_from(position, rays.inverse() * from_surface);
        Some(lights_all.then(|| Neighbour { output, picture: picture(), edge_weight: EdgeWeight::of(&other.blend) }))
    };
    let neighbours: Option<Vec<Neighbour>> = others.filter_map(neighbour).collect();
    let source = ProjectorSource {
        pinhole,
        direction: pinhole.seen_from(to_surface(eye), to_viewer * from_surface),
        bounds,
        rim: (!bounds.is_all()).then(|| RimForms::of(&pinhole, &bounds)),
        // A rotation about x by the tilt brings the pole to +y and the front to −z.
        dome_direction: pinhole
            .seen_from(to_surface(DVec3::ZERO), DMat3::from_rotation_x(rig.dome.tilt) * from_surface),
        neighbours: neighbours?,
        edge_weight: EdgeWeight::of(&output.blend),
        evaluation: EvaluationMethod::Forms,
    };
    pinhole.looks_at_it().then_some(source)
}

/// Returns the formula of a projector with any lens, possibly before a mirror. `None` if it shares
/// its light or its blacks with others, for lenses without a formula, and for screens that are no
/// quadrics.
fn lens(rig: &Rig, index: usize, optics: &Optics, size: (u32, u32)) -> Option<OpticsSource> {
    let output = &rig.outputs[index];
    let mut others = rig.outputs.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, other)| other);
    let shares = output.blend.overlap && others.any(|other| other.kind.is_projector());
    if shares || rig.outputs.iter().any(|output| output.blend.contrast.is_some()) {
        return None;
    }
    let Screen { pose, shape } = rig.surface();
    let ClosedForm { middle, surface: ClosedSurface::Quadric(quadric), bounds } = shape.closed_form()? else {
        return None;
    };
    let from_surface = DAffine3 { matrix3: pose.rotation, translation: pose.position + pose.rotation * middle };
    let to_surface = from_surface.inverse();
    let in_surface = |mirror: Sphere| Sphere { center: to_surface.transform_point3(mirror.center), ..mirror };
    let seen_from =
        |eye: DVec3, target: DMat3| DAffine3 { matrix3: target, translation: -(target * eye) } * from_surface;
    Some(OpticsSource {
        position: to_surface.transform_point3(optics.pose.position),
        rotation: to_surface.matrix3 * optics.pose.rotation,
        light: Light::of(&optics.lens, f64::from(size.0) / f64::from(size.1), optics.mirror.map(in_surface))?,
        quadric,
        bounds,
        to_viewer: seen_from(rig.eye(output).position, viewer_rotation(rig).transpose()),
        to_dome: seen_from(DVec3::ZERO, DMat3::from_rotation_x(rig.dome.tilt)),
    })
}

/// Returns the rotation viewer axes → dome axes turned so that the pole is +y and the front −z.
pub fn dome_axes(rig: &Rig) -> DMat3 {
    let viewer = &rig.viewer;
    DMat3::from_rotation_x(rig.dome.tilt) * crate::geom::pose::rotation(viewer.yaw, viewer.pitch, viewer.roll)
}
