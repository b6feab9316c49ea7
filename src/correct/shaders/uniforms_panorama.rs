//! The constants of a panorama's pass.

use crate::correct::shaders::constants::{FisheyeConstants, PanoramaConstants, Shared, Values};
use crate::correct::shaders::polynomials::{circular, radial};
use crate::correct::single;
use crate::error::{Error, ErrorKind, Result};
use crate::geom::Panorama;
use crate::geom::lenses::equidistant::RadialForm;
use glam::{DMat3, DVec3};

/// Rotations and offset for a panorama's unit directions.
pub(super) struct Axes {
    /// Picture axes → base.
    pub rotation: DMat3,
    /// Vector that is added, in base.
    pub shift: DVec3,
    /// Picture axes → dome axes.
    pub dome: DMat3,
    /// True if a vector is added.
    pub off_centre: bool,
}

/// Returns the constants of a panorama.
pub(super) fn values(panorama: &Panorama, axes: &Axes, shared_part: Shared) -> Result<Values> {
    let (rotation, dome) = (single::matrix3(axes.rotation), single::matrix3(axes.dome));
    let shift = single::values(axes.shift.to_array());
    let mut out = PanoramaConstants { shared_part, rotation, shift, dome, ..PanoramaConstants::default() };
    match panorama {
        Panorama::Fisheye(lens) => {
            let form = RadialForm::of(lens)
                .ok_or_else(|| Error::new(ErrorKind::Internal, "A lens without a closed form has no table."))?;
            let (sine, cosine, root) = radial(&form)?;
            let off_centre = axes.off_centre.into();
            return Ok(Values::Fisheye(Box::new(FisheyeConstants {
                shared_part,
                sine,
                cosine,
                root,
                off_centre,
                rotation,
                shift,
                dome,
            })));
        }
        Panorama::Equirectangular(span) => {
            (out.sine, out.cosine) = circular(span.width)?;
            (out.up_sine, out.up_cosine) = circular(span.top - span.bottom)?;
            let (sine, cosine) = (0.5 * (span.bottom + span.top)).sin_cos();
            out.middle = single::values([sine, cosine]);
        }
        Panorama::Cylindrical(span) => {
            out.kind = 1;
            (out.sine, out.cosine) = circular(span.width)?;
            let (middle, half) = span.heights();
            out.middle = single::values([middle, half]);
        }
        Panorama::CubeStrip => out.kind = 2,
    }
    Ok(Values::Panorama(Box::new(out)))
}
