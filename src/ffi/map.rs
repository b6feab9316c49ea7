//! Mathematics that needs no GPU.

use super::argument::Place;
use super::handle::Handle;
use super::rig::cupola_rig;
use super::status::{call, cupola_status};
use crate::error::{Error, ErrorKind};
use crate::warp;
use glam::DVec2;

/// Computes the direction that a pixel of an output shows, in double precision and without a GPU.
///
/// # Parameters
/// - `rig`: the rig.
/// - `output`: index of the output, from 0.
/// - `width`, `height`: size of the output in pixels, at least 1.
/// - `column`, `row`: point in pixels from the top left corner; centres of pixels are at + 0.5.
/// - `direction`: receives 3 numbers: a unit vector in the axes of the program's camera (x right, y
///   up, -z forward), or 3 NaN where the point shows nothing.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, an output that does not exist, a size of 0, or a
///   point that is not finite.
///
/// # Threads
/// Any thread, and several at the same time with the same rig.
///
/// # Safety
/// `rig` is a live handle; `direction` has room for 3 numbers.
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
        // SAFETY: as this function's contract.
        let rig = unsafe { &cupola_rig::borrow(rig)?.rig };
        // SAFETY: room for three numbers, by this function's contract.
        let direction = unsafe { Place::new(direction.cast::<[f64; 3]>(), "direction") }?;
        if output as usize >= rig.outputs.len() || width == 0 || height == 0 || !column.is_finite() || !row.is_finite()
        {
            let message = format!(
                "output {output} at {width} × {height} pixels, point ({column}, {row}); expected an output below {}, a size of at least 1 × 1 and a finite point",
                rig.outputs.len()
            );
            return Err(Error::new(ErrorKind::InvalidArgument, message));
        }
        let seen = warp::WarpMap::new(rig, output as usize, (width, height), None)?.direction(DVec2::new(column, row));
        direction.set(seen.map_or([f64::NAN; 3], |d| warp::camera_direction(rig, d).to_array()));
        Ok(())
    })
}
