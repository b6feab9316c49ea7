//! OpenGL's error flag.

use crate::backend::gl::driver::api::{GL_NO_ERROR, Gl};

/// Errors that are asked for at once, at most.
pub const MOST_ERRORS: u64 = 64;

/// Takes the errors that are pending; gives the first.
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
