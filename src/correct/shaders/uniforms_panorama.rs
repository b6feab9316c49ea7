//! The constants of a panorama's pass.

use crate::correct::shaders::uniforms::{Constants, circular, radial};
use crate::error::{Error, ErrorKind, Result};
use crate::geom::Panorama;
use crate::geom::fisheye::RadialForm;

/// Sets what says how a panorama shows directions.
pub(in crate::correct) fn set(out: &mut Constants, panorama: &Panorama) -> Result<()> {
    match panorama {
        Panorama::Fisheye(lens) => {
            let form = RadialForm::of(lens)
                .ok_or_else(|| Error::new(ErrorKind::Internal, "A lens without a closed form was not made a table."))?;
            radial(out, &form)
        }
        Panorama::Equirectangular(span) => {
            circular(out, ["sine", "cosine"], span.width)?;
            circular(out, ["up_sine", "up_cosine"], span.top - span.bottom)?;
            let (sine, cosine) = (0.5 * (span.bottom + span.top)).sin_cos();
            out.set("middle", &[sine, cosine])
        }
        Panorama::Cylindrical(span) => {
            out.set("kind", &[1.0])?;
            circular(out, ["sine", "cosine"], span.width)?;
            let (middle, half) = span.heights();
            out.set("middle", &[middle, half])
        }
        Panorama::CubeStrip => out.set("kind", &[2.0]),
    }
}
