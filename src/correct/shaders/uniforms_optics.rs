//! The constants of the pass of a projector with a fisheye or a mirror.

use crate::correct::passes::optics::{Light, OpticsSource};
use crate::correct::passes::output_pass::Batch;
use crate::correct::shaders::constants::{OpticsConstants, Shared, Values};
use crate::correct::shaders::polynomials::radial;
use crate::correct::single;
use crate::error::Result;
use crate::geom::screen::{HalfSpace, Join};
use glam::{DAffine3, DMat3, DVec3};

/// Returns the constants of such a projector; `base`: viewer axes → base.
pub(super) fn values(source: &OpticsSource, batch: &Batch, base: DMat3, shared_part: Shared) -> Result<Values> {
    let to_base = DAffine3 { matrix3: base, translation: DVec3::ZERO } * source.to_viewer;
    let mut out = OpticsConstants {
        shared_part,
        weights: single::values(source.quadric.weights.to_array()),
        to_base: single::matrix3(to_base.matrix3),
        shift: single::values(to_base.translation.to_array()),
        dome: single::matrix3(source.to_dome.matrix3),
        dome_shift: single::values(source.to_dome.translation.to_array()),
        ..OpticsConstants::default()
    };
    match &source.light {
        Light::Fisheye { form, scale, offset } => {
            out.fisheye = 1;
            out.disc = single::values([scale.x, scale.y, offset.x, offset.y]);
            (out.sine, out.cosine, out.root) = radial(form)?;
            out.rays = single::matrix3(source.rotation);
            out.origin = single::values(source.position.to_array());
            out.level = single::value(source.quadric.depth(source.position));
        }
        Light::Mirror { rays, mirror } => {
            out.with_mirror = 1;
            out.rays = single::matrix3(source.rotation * *rays);
            out.radius = single::value(mirror.radius);
            out.moment = single::matrix3(source.moment(rays, mirror));
            out.origin = single::values(mirror.center.to_array());
            out.level = single::value(source.quadric.level);
        }
    }
    if batch.edge && !source.bounds.is_all() {
        let sides = source.bounds.sides.as_ref();
        out.edge_test = sides.map_or(1, |sides| if sides.join == Join::Both { 2 } else { 3 });
        for (to, space) in out.limits.iter_mut().zip(&source.bounds.limits) {
            *to = half_space(space.as_ref());
        }
        for (to, space) in out.sides.iter_mut().zip(sides.iter().flat_map(|sides| &sides.spaces)) {
            *to = half_space(Some(space));
        }
    }
    Ok(Values::Optics(Box::new(out)))
}

/// Returns a half-space as the shaders take it: all of space if there is none, or if its normal is
/// 0.
fn half_space(space: Option<&HalfSpace>) -> [f32; 4] {
    match space {
        Some(space) if space.normal != DVec3::ZERO => single::values(space.normal.extend(-space.distance).to_array()),
        _ => [0.0; 4],
    }
}
