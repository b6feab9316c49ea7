//! OpenGL's error flag.

use crate::backend::gl::driver::api::{GL_NO_ERROR, Gl};

/// Greatest number of errors that are read at once.
pub const MOST_ERRORS: u64 = 64;

/// Reads and clears the pending errors. Returns the first one, or `GL_NO_ERROR`.
pub fn drain(gl: &Gl) -> u32 {
    let mut first = GL_NO_ERROR;
    for _ in 0..MOST_ERRORS {
        // SAFETY: a context is current.
        let error = unsafe { gl.get_error() };
        if error == GL_NO_ERROR {
            break;
        }
        if first == GL_NO_ERROR {
            first = error;
        }
    }
    first
}
