//! Vulkan: a program whose shaders project vertices straight to the pictures of outputs.

use super::rig::cupola_rig;
use super::status::{call, copy_text, cupola_status, null};
use super::vk::{create, cupola_vk, cupola_vk_options, handle};
use crate::correct::projection;
use crate::runtime::embedded::vulkan::EmbeddedVulkan;
use std::ffi::c_char;

/// As `cupola_vk_create`, for a program that draws all views by the functions of `cupola_vk_projection_source`. An
/// output with the method `vertex` or `primitive` then has one view, which is its own picture (pixel for pixel, but where layers have to be
/// alike or the rig's `quality` asks for more); the matrices of `cupola_vk_get_view` do not lead there. Edges between vertices stay straight: the program's models have to be fine.
///
/// # Safety
/// As for `cupola_vk_create`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_create_projecting(
    rig: *const cupola_rig,
    options: *const cupola_vk_options,
    vk: *mut *mut cupola_vk,
) -> cupola_status {
    // SAFETY: as promised above.
    call(|| unsafe { create(rig, options, vk, EmbeddedVulkan::projecting) })
}

/// GLSL for the last stage before rasterisation: a uniform block with `vec4 cupola_view[8]` (std140) in descriptor set
/// `set` at `binding`, and `vec4 cupola_fix(vec4)`, which takes what the program would give to `gl_Position`, with its own
/// projection, to the view. It stands after `#version` (450 or later) and before `main`.
///
/// `buffer`: room for `size` bytes, or null to ask only for the length. `length` (may be null): the whole text's length
/// in bytes without the NUL. What does not fit is cut.
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
        // SAFETY: as promised above.
        unsafe { copy_text(&projection::vulkan_functions(set, binding, true), buffer, size, length) };
        Ok(())
    })
}

/// The 8 vectors of `cupola_view` for a view, if the program draws with the perspective `matrix` (16 numbers, column by
/// column; Vulkan's clip space with y down). They change with the view, with the matrix and with the size.
///
/// # Safety
/// `vk` is a live handle; `matrix` points at 16 numbers, `vectors` at room for 32.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_get_projection(
    vk: *mut cupola_vk,
    index: u32,
    matrix: *const f32,
    vectors: *mut f32,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let vk = unsafe { handle(vk) }?;
        if matrix.is_null() || vectors.is_null() {
            return Err(null(if matrix.is_null() { "matrix" } else { "vectors" }));
        }
        // SAFETY: as promised above.
        let matrix = unsafe { *matrix.cast::<[f32; 16]>() }.map(f64::from);
        let found = vk.embedded.projection(index as usize, &matrix)?;
        // SAFETY: as promised above.
        unsafe { *vectors.cast::<[f32; 32]>() = found };
        Ok(())
    })
}
