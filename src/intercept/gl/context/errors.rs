//! OpenGL's error flag, which the program's calls and internal calls of Cupola share.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::process::log;

/// Removes errors from the driver that only questions of Cupola caused. A driver may refuse these
/// questions.
pub fn drop_errors(gl: &Gl) {
    // SAFETY: asks for the error flag; a driver has a handful of such flags at most.
    for _ in 0..8 {
        if unsafe { gl.get_error() } == api::GL_NO_ERROR {
            break;
        }
    }
}

/// Counts the errors since [`Driver::take_errors`] as errors of Cupola.
pub fn take_own_errors(driver: &mut Driver) {
    // SAFETY: as above.
    for _ in 0..8 {
        let error = unsafe { driver.gl.get_error() };
        if error == api::GL_NO_ERROR {
            break;
        }
        driver.note_own_error();
        log::once(&format!("an internal OpenGL call failed with error 0x{error:04X}"));
    }
}
