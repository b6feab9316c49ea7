//! OpenGL: a program whose shaders project vertices straight to the pictures of outputs.

use super::types::cupola_gl_options;
use super::{create, cupola_gl};
use crate::correct::projected::projection;
use crate::ffi::argument::copy_text;
use crate::ffi::handle::Handle;
use crate::ffi::rig::cupola_rig;
use crate::ffi::status::{call, cupola_status};
use crate::ffi::view::get_projection;
use crate::runtime::embedded::Embedded;
use std::ffi::c_char;

/// Does what `cupola_gl_create` does, for a program that draws all views with the functions of
/// `cupola_gl_projection_source`.
///
/// An output with the method `vertex` or `primitive` then has one view, which is its own picture,
/// pixel for pixel; the matrices of `cupola_gl_get_view` do not apply to it. Edges between vertices
/// stay straight, so the program's models have to be fine.
///
/// # Parameters
/// As for `cupola_gl_create`.
///
/// # Returns
/// As for `cupola_gl_create`.
///
/// # Ownership
/// The caller owns `*gl` and destroys it with `cupola_gl_destroy`.
///
/// # Threads
/// Context current.
///
/// # Safety
/// As for `cupola_gl_create`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_create_projecting(
    rig: *const cupola_rig,
    options: *const cupola_gl_options,
    gl: *mut *mut cupola_gl,
) -> cupola_status {
    // SAFETY: as this function's contract.
    call(|| unsafe { create(rig, options, gl, Embedded::projecting) })
}

/// Copies GLSL for the last shader stage before rasterisation: `uniform vec4 cupola_view[8]`, and
/// `vec4 cupola_fix(vec4)`, which turns the value for `gl_Position`, computed with the program's
/// own projection, into that of the view. The text belongs between `#version` (GLSL 1.20 or ESSL
/// 3.00 at least) and `main`.
///
/// # Parameters
/// - `for_es`: 0 for GLSL, any other value for ESSL.
/// - `buffer`: room for `size` bytes, or null to get the length only. The text is cut to fit, with
///   its NUL.
/// - `size`: size of the buffer in bytes.
/// - `length`: receives the length of the whole text in bytes without its NUL; may be null.
///
/// # Returns
/// `CUPOLA_OK`, or `CUPOLA_INTERNAL`.
///
/// # Threads
/// Any thread; no context is needed.
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
        // SAFETY: as this function's contract.
        unsafe { copy_text(&projection::functions(for_es != 0, true), buffer, size, length) };
        Ok(())
    })
}

/// Computes the 8 vectors of the uniform `cupola_view` for a view. They depend on the view, on the
/// matrix and on the size of the picture.
///
/// # Parameters
/// - `gl`: the object.
/// - `index`: index of the view.
/// - `matrix`: 16 numbers, column by column: the perspective matrix with which the program draws.
/// - `vectors`: receives 32 numbers.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, an index without a view, or a matrix that is no
///   perspective.
///
/// # Threads
/// Any thread; no context is needed.
///
/// # Safety
/// `gl` is a live handle; `matrix` points to 16 numbers, `vectors` to room for 32.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_get_projection(
    gl: *mut cupola_gl,
    index: u32,
    matrix: *const f32,
    vectors: *mut f32,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let gl = unsafe { cupola_gl::borrow(gl) }?;
        // SAFETY: as this function's contract.
        unsafe { get_projection(matrix, vectors, |matrix| gl.embedded.projection(index as usize, matrix)) }
    })
}
