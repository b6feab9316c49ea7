//! Pure maths: needs no GPU.

use super::rig::cupola_rig;
use super::status::{call, cupola_status, null};
use crate::error::{Error, ErrorKind};
use crate::warp;
use glam::DVec2;

/// The direction that a pixel of an output shows, exactly: a unit vector in the eye axes of the
/// program's camera (x right, y up, -z forward), or three NaN where the pixel shows nothing.
///
/// `output`: counted from 0. `width`, `height`: the output's size in pixels. `column`, `row`: the
/// point in pixels from the top left; pixel centres are at + 0.5.
///
/// # Safety
/// `rig` is a live handle; `direction` has room for three doubles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_map_direction(
    rig: *const cupola_rig,
    output: u32,
    width: u32,
    height: u32,
    column: f64,
    row: f64,
    direction: *mut f64,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let rig = unsafe { &rig.as_ref().ok_or_else(|| null("rig"))?.rig };
        if direction.is_null() {
            return Err(null("direction"));
        }
        if output as usize >= rig.outputs.len() || width == 0 || height == 0 || !column.is_finite() || !row.is_finite()
        {
            let message = format!(
                "output {output} at {width} × {height} pixels, point ({column}, {row}): right would be an output below {}, a size of at least 1 × 1 and a finite point",
                rig.outputs.len()
            );
            return Err(Error::new(ErrorKind::InvalidArgument, message));
        }
        let seen = warp::WarpMap::new(rig, output as usize, (width, height), None)?.direction(DVec2::new(column, row));
        let answer = seen.map_or([f64::NAN; 3], |d| warp::camera_direction(rig, d).to_array());
        // SAFETY: room for three doubles, as promised above.
        unsafe { std::ptr::copy_nonoverlapping(answer.as_ptr(), direction, 3) };
        Ok(())
    })
}
