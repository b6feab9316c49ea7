//! Vulkan: a program whose shaders project vertices straight to the pictures of outputs.

use super::types::cupola_vk_options;
use super::{create, cupola_vk};
use crate::correct::projected::projection;
use crate::ffi::argument::copy_text;
use crate::ffi::handle::Handle;
use crate::ffi::rig::cupola_rig;
use crate::ffi::status::{call, cupola_status};
use crate::ffi::view::get_projection;
use crate::runtime::embedded::vulkan::EmbeddedVulkan;
use std::ffi::c_char;

/// Does what `cupola_vk_create` does, for a program that draws all views with the functions of
/// `cupola_vk_projection_source`.
///
/// An output with the method `vertex` or `primitive` then has one view, which is its own picture
/// (pixel for pixel, except where layers have to be alike or the rig's `quality` asks for more);
/// the matrices of `cupola_vk_get_view` do not apply to it. Edges between vertices stay straight,
/// so the program's models have to be fine.
///
/// # Parameters
/// As for `cupola_vk_create`.
///
/// # Returns
/// As for `cupola_vk_create`.
///
/// # Ownership
/// The caller owns `*vk` and destroys it with `cupola_vk_destroy`.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// As for `cupola_vk_create`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_create_projecting(
    rig: *const cupola_rig,
    options: *const cupola_vk_options,
    vk: *mut *mut cupola_vk,
) -> cupola_status {
    // SAFETY: as this function's contract.
    call(|| unsafe { create(rig, options, vk, EmbeddedVulkan::projecting) })
}

/// Copies GLSL for the last shader stage before rasterisation: a uniform block with `vec4
/// cupola_view[8]` (std140), and `vec4 cupola_fix(vec4)`, which turns the value for `gl_Position`,
/// computed with the program's own projection, into that of the view. The text belongs between
/// `#version` (450 at least) and `main`.
///
/// # Parameters
/// - `set`, `binding`: descriptor set and binding of the uniform block.
/// - `buffer`: room for `size` bytes, or null to get the length only. The text is cut to fit, with
///   its NUL.
/// - `size`: size of the buffer in bytes.
/// - `length`: receives the length of the whole text in bytes without its NUL; may be null.
///
/// # Returns
/// `CUPOLA_OK`, or `CUPOLA_INTERNAL`.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `buffer` has room for `size` bytes or is null; `length` is null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_projection_source(
    set: u32,
    binding: u32,
    buffer: *mut c_char,
    size: usize,
    length: *mut usize,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        unsafe { copy_text(&projection::vulkan_functions(set, binding, true), buffer, size, length) };
        Ok(())
    })
}

/// Computes the 8 vectors of `cupola_view` for a view. They depend on the view, on the matrix and
/// on the size of the picture.
///
/// # Parameters
/// - `vk`: the object.
/// - `index`: index of the view.
/// - `matrix`: 16 numbers, column by column: the perspective matrix with which the program draws,
///   to Vulkan's clip space with y down.
/// - `vectors`: receives 32 numbers.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, an index without a view, or a matrix that is no
///   perspective.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `vk` is a live handle; `matrix` points to 16 numbers, `vectors` to room for 32.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_get_projection(
    vk: *mut cupola_vk,
    index: u32,
    matrix: *const f32,
    vectors: *mut f32,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let vk = unsafe { cupola_vk::borrow(vk) }?;
        // SAFETY: as this function's contract.
        unsafe { get_projection(matrix, vectors, |matrix| vk.embedded.projection(index as usize, matrix)) }
    })
}
