//! Values of a context's state, one at a time.

use crate::backend::gl::driver::api::Gl;

/// One integer of the context; 0 where it knows no such name.
pub(crate) fn integer(gl: &Gl, name: u32) -> i32 {
    // Some names answer with more than one number in some profiles.
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
