//! Values of a context's state, one at a time.

use crate::backend::gl::driver::api::Gl;

/// Returns one integer of the context's state; 0 if the context does not know the name.
pub(crate) fn integer(gl: &Gl, name: u32) -> i32 {
    // Some names have more than one value in some profiles.
    let mut values = [0; 4];
    // SAFETY: a context is current; no name used here has more than four values.
    unsafe { gl.get_integerv(name, values.as_mut_ptr()) };
    values[0]
}

pub(in crate::backend::gl) fn boolean(gl: &Gl, name: u32) -> bool {
    let mut value = 0;
    // SAFETY: a context is current; the name has one value.
    unsafe { gl.get_booleanv(name, &mut value) };
    value != 0
}
