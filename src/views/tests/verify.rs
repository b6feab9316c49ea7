//! Check of a plan against every pixel of every output.

use crate::rig::*;
use crate::views::*;
use crate::warp::{WarpMap, exact_direction};
use glam::{DVec2, DVec3};

/// Returns the place at which a view shows a direction, in its tangents.
fn tangents(view: &View, direction: DVec3) -> Option<DVec2> {
    let local = view.rotation * direction;
    (local.z < 0.0).then(|| DVec2::new(local.x, local.y) / -local.z)
}

/// Returns the place at which a view shows a direction, in texels from the tile's lower left
/// corner.
pub(super) fn texel(view: &View, direction: DVec3) -> Option<DVec2> {
    let at = tangents(view, direction)?;
    let part = DVec2::new(
        (at.x - view.frustum.left) / view.frustum.width(),
        (at.y - view.frustum.bottom) / view.frustum.height(),
    );
    Some(part * DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height)))
}

/// Returns the view that serves a direction that `output` shows.
pub(super) fn answering(plan: &ViewPlan, output: usize, direction: DVec3) -> Option<usize> {
    plan.output_views[output].iter().copied().find(|&view| {
        let view = &plan.views[view];
        tangents(view, direction).is_some_and(|at| view.owned.contains(at.x, at.y))
    })
}

/// Returns the texels per pixel around a pixel, in the direction with the fewest; for a domemaster,
/// per nominal pixel.
fn least_density(rig: &Rig, output: usize, size: (u32, u32), pixel: DVec2, view: &View) -> Option<f64> {
    const STEP: f64 = 1e-3;
    let at = |offset: DVec2| texel(view, exact_direction(rig, output, size, pixel + offset)?);
    let derivative = |axis: DVec2| Some((at(axis * STEP)? - at(-axis * STEP)?) / (2.0 * STEP));
    let nominal = rig.views.resolution == Resolution::Nominal;
    let (first, second) = if let (OutputKind::Domemaster { aperture, .. }, true) = (&rig.outputs[output].kind, nominal)
    {
        let middle = 0.5 * DVec2::new(f64::from(size.0), f64::from(size.1));
        let radial = (pixel - middle).normalize_or(DVec2::X);
        let angle = (pixel - middle).length() * aperture / f64::from(size.0.min(size.1));
        // Around the axis, a pixel of the lens covers only sin(angle)/angle of a nominal one.
        (derivative(radial)?, derivative(radial.perp())? * if angle > 0.0 { angle / angle.sin() } else { 1.0 })
    } else {
        (derivative(DVec2::X)?, derivative(DVec2::Y)?)
    };
    let (a, b, c) = (first.length_squared(), first.dot(second), second.length_squared());
    Some((0.5 * (a + c) - (0.25 * (a - c) * (a - c) + b * b).sqrt()).max(0.0).sqrt())
}

/// Checks a plan against every pixel of every output. Returns the number of pixels whose resolution
/// was measured, or a description of the error.
pub(super) fn verify(rig: &Rig, request: &Request, plan: &ViewPlan) -> std::result::Result<usize, String> {
    let mut measured = 0;
    let mut used = vec![false; plan.views.len()];
    let scaled_down = plan.notes.iter().any(|note| note.contains("of the resolution asked for"));
    for (output, &size) in request.output_sizes.iter().enumerate().filter(|(_, size)| **size != (0, 0)) {
        let map = WarpMap::new(rig, output, size, Some(crate::views::sampling::output_map::UNIT_FRUSTUM)).unwrap();
        for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
            let wrong = |what: String| Err(format!("{what} at pixel {x}, {y} of output {output}, {rig:?}, {plan:?}"));
            let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let Some(direction) = map.direction(pixel) else { continue };
            let Some(index) = answering(plan, output, direction) else { return wrong("no view".into()) };
            used[index] = true;
            let view = &plan.views[index];
            let size = DVec2::new(f64::from(view.tile.width), f64::from(view.tile.height));
            let slack = 1e-9 * size.max_element();
            let inside = |at: DVec2| at.cmpge(DVec2::splat(0.5 - slack)).all() && at.cmple(size - 0.5 + slack).all();
            if !texel(view, direction).is_some_and(inside) {
                return wrong(format!("the footprint leaves the tile of view {index}"));
            }
            if scaled_down || view.program_lens {
                continue;
            }
            if let Some(density) = least_density(rig, output, request.output_sizes[output], pixel, view) {
                measured += 1;
                if density < 0.9999 * rig.views.quality {
                    return wrong(format!("{density} texels per pixel in view {index}"));
                }
            }
        }
    }
    match used.iter().position(|used| !used) {
        Some(idle) => Err(format!("nothing samples view {idle} of {rig:?}, {plan:?}")),
        None => Ok(measured),
    }
}
