//! The constants of the pass of a projector with a fisheye or a mirror.

use crate::correct::passes::optics::{Light, OpticsSource};
use crate::correct::passes::output_pass::Batch;
use crate::correct::shaders::uniforms::{Constants, radial};
use crate::error::Result;
use crate::geom::screen::{HalfSpace, Join};
use glam::{DAffine3, DMat3, DVec3};

/// Sets what only such projectors have; `base`: viewer axes → base.
pub(in crate::correct) fn set(out: &mut Constants, source: &OpticsSource, batch: &Batch, base: DMat3) -> Result<()> {
    match &source.light {
        Light::Fisheye { form, scale, offset } => {
            out.set_flag("fisheye", true)?;
            out.set("disc", &[scale.x, scale.y, offset.x, offset.y])?;
            radial(out, form)?;
            out.set_matrix("rays", source.rotation)?;
            out.set("origin", &source.position.to_array())?;
            out.set("level", &[source.quadric.depth(source.position)])?;
        }
        Light::Mirror { rays, mirror } => {
            out.set_flag("with_mirror", true)?;
            out.set_matrix("rays", source.rotation * *rays)?;
            out.set("radius", &[mirror.radius])?;
            out.set_matrix("moment", source.moment(rays, mirror))?;
            out.set("origin", &mirror.center.to_array())?;
            out.set("level", &[source.quadric.level])?;
        }
    }
    out.set("weights", &source.quadric.weights.to_array())?;
    let to_base = DAffine3 { matrix3: base, translation: DVec3::ZERO } * source.to_viewer;
    out.set_matrix("to_base", to_base.matrix3)?;
    out.set("shift", &to_base.translation.to_array())?;
    out.set_matrix("dome", source.to_dome.matrix3)?;
    out.set("dome_shift", &source.to_dome.translation.to_array())?;
    if batch.edge && !source.bounds.is_all() {
        let sides = source.bounds.sides.as_ref();
        out.set("rim", &[sides.map_or(1.0, |sides| if sides.join == Join::Both { 2.0 } else { 3.0 })])?;
        for (i, space) in source.bounds.limits.iter().enumerate() {
            half_space(out, &format!("limits[{i}]"), space.as_ref())?;
        }
        for (i, space) in sides.iter().flat_map(|sides| &sides.spaces).enumerate() {
            half_space(out, &format!("sides[{i}]"), Some(space))?;
        }
    }
    Ok(())
}

/// Sets a half-space; all of space where there is none, or it says only that there is a point at all.
fn half_space(out: &mut Constants, path: &str, space: Option<&HalfSpace>) -> Result<()> {
    let [x, y, z, w] = match space {
        Some(space) if space.normal != DVec3::ZERO => space.normal.extend(-space.distance).to_array(),
        _ => [0.0; 4],
    };
    out.set(path, &[x, y, z, w])
}
