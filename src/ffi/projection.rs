//! OpenGL: a program whose shaders project vertices straight to the pictures of outputs.

use super::gl::{create, cupola_gl, cupola_gl_options, handle};
use super::rig::cupola_rig;
use super::status::{call, copy_text, cupola_status, null};
use crate::correct::projection;
use crate::runtime::embedded::Embedded;
use std::ffi::c_char;

/// As `cupola_gl_create`, for a program that draws all views by the functions of `cupola_gl_projection_source`. An
/// output with the method `vertex` or `primitive` then has one view, which is its own picture, pixel for pixel; the matrices of
/// `cupola_gl_get_view` do not lead there. Edges between vertices stay straight: the program's models have to be fine.
///
/// # Safety
/// As for `cupola_gl_create`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_create_projecting(
    rig: *const cupola_rig,
    options: *const cupola_gl_options,
    gl: *mut *mut cupola_gl,
) -> cupola_status {
    // SAFETY: as promised above.
    call(|| unsafe { create(rig, options, gl, Embedded::projecting) })
}

/// GLSL for the last stage before rasterisation: `uniform vec4 cupola_view[8]` and `vec4 cupola_fix(vec4)`, which takes
/// what the program would give to `gl_Position`, with its own projection, to the view. It stands after `#version` and
/// before `main`, and needs GLSL 1.20 or ESSL 3.00 (`for_es` not 0).
///
/// `buffer`: room for `size` bytes, or null to ask only for the length. `length` (may be null): the whole text's length
/// in bytes without the NUL. What does not fit is cut.
///
/// # Safety
/// `buffer` has room for `size` bytes or is null; `length` is null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_projection_source(
    for_es: i32,
    buffer: *mut c_char,
    size: usize,
    length: *mut usize,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        unsafe { copy_text(&projection::functions(for_es != 0, true), buffer, size, length) };
        Ok(())
    })
}

/// The 8 vectors of `cupola_view` for a view, if the program draws with the perspective `matrix` (16 numbers, column by
/// column). They change with the view, with the matrix and with the size.
///
/// # Safety
/// `gl` is a live handle; `matrix` points at 16 numbers, `vectors` at room for 32.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_get_projection(
    gl: *mut cupola_gl,
    index: u32,
    matrix: *const f32,
    vectors: *mut f32,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let gl = unsafe { handle(gl) }?;
        if matrix.is_null() || vectors.is_null() {
            return Err(null(if matrix.is_null() { "matrix" } else { "vectors" }));
        }
        // SAFETY: as promised above.
        let matrix = unsafe { *matrix.cast::<[f32; 16]>() }.map(f64::from);
        let found = gl.embedded.projection(index as usize, &matrix)?;
        // SAFETY: as promised above.
        unsafe { *vectors.cast::<[f32; 32]>() = found };
        Ok(())
    })
}
