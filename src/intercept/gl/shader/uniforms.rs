//! Finds the projection among a program's 4×4 matrices.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::shader::{program_pipelines, programs};
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::shader::programs::Program;
use crate::intercept::gl::state::shader::uniforms::{Matrix, MatrixLocation, PositionNames, Uniforms};
use crate::intercept::lens::{rank, transposed};
use crate::lock::Lock;
use std::ffi::{CStr, c_char};

/// Of longer arrays of matrices, which are bones or instances, only the first is looked at.
const LONGEST: i32 = 8;

/// The 4×4 matrices of a linked program that may flow into its position, all if that is not known, and the index of the
/// uniform called `ours`.
pub fn read(
    gl: &Gl,
    profile: &Profile,
    program: u32,
    ours: &str,
    position: Option<&PositionNames>,
) -> (Uniforms, Option<u32>) {
    let mut uniforms = Uniforms { generation: u64::MAX, ..Uniforms::default() };
    let mut own_uniform = None;
    let mut count = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_programiv(program, api::GL_ACTIVE_UNIFORMS, &mut count) };
    for index in 0..u32::try_from(count).unwrap_or(0) {
        let mut text: [c_char; 256] = [0; 256];
        let (mut length, mut size, mut kind) = (0, 0, 0);
        // SAFETY: writes at most 256 characters with their NUL.
        let name = unsafe {
            gl.get_active_uniform(program, index, 256, &mut length, &mut size, &mut kind, text.as_mut_ptr());
            CStr::from_ptr(text.as_ptr())
        };
        let shown = name.to_string_lossy();
        if shown.strip_suffix("[0]").unwrap_or(&shown) == ours {
            own_uniform = Some(index);
        }
        let flows = position.is_none_or(|names| names.contain(&shown));
        if kind != api::GL_FLOAT_MAT4 || shown.starts_with("gl_") || !flows {
            continue;
        }
        // SAFETY: a NUL-terminated name.
        let location = unsafe { gl.get_uniform_location(program, name.as_ptr()) };
        let place = if location >= 0 {
            Some(MatrixLocation::Uniform(location))
        } else if profile.version >= 31 || (profile.es && profile.version >= 30) {
            block_place(gl, program, index)
        } else {
            None
        };
        let Some(place) = place else { continue };
        // The elements of an array have locations that follow each other.
        let elements = if location >= 0 && size <= LONGEST { size.max(1) } else { 1 };
        let mut place = Some(place);
        for element in 0..elements {
            let mut value = [0f32; 16];
            if location >= 0 {
                // SAFETY: a 4×4 matrix is sixteen floats.
                unsafe { gl.get_uniformfv(program, location + element, value.as_mut_ptr()) };
            }
            let place = place.take().unwrap_or(MatrixLocation::Uniform(location + element));
            let value = value.map(f64::from);
            uniforms.matrices.push(Matrix { place, rank: rank(&shown), value, name: (*shown).into(), read: None });
        }
    }
    (uniforms, own_uniform)
}

fn block_place(gl: &Gl, program: u32, index: u32) -> Option<MatrixLocation> {
    let ask = |what: u32| {
        let mut answer = -1;
        // SAFETY: one index in, one integer out.
        unsafe { gl.get_active_uniformsiv(program, 1, &index, what, &mut answer) };
        answer
    };
    let block = u32::try_from(ask(api::GL_UNIFORM_BLOCK_INDEX)).ok()?;
    let mut binding = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_active_uniform_blockiv(program, block, api::GL_UNIFORM_BLOCK_BINDING, &mut binding) };
    Some(MatrixLocation::Block {
        binding: u32::try_from(binding).ok()?,
        offset: usize::try_from(ask(api::GL_UNIFORM_OFFSET)).ok()?,
        stride: usize::try_from(ask(api::GL_UNIFORM_MATRIX_STRIDE)).ok()?,
        row_major: ask(api::GL_UNIFORM_IS_ROW_MAJOR) == 1,
    })
}

/// Notes a matrix that the program sets.
///
/// # Safety
/// `value` must point at `count` matrices, as the program promises OpenGL.
unsafe fn note<T: Copy + Into<f64>>(
    program: Option<&Program>,
    location: i32,
    count: i32,
    transpose: u8,
    value: *const T,
) {
    let Some(program) = program else { return };
    if location < 0 || count < 1 || value.is_null() {
        return;
    }
    let mut uniforms = program.uniforms.locked();
    for element in 0..count.min(LONGEST) {
        // SAFETY: as promised above.
        let matrix = std::array::from_fn(|i| unsafe { (*value.add(16 * element as usize + i)).into() });
        let matrix = if transpose != 0 { transposed(&matrix) } else { matrix };
        uniforms.set(location + element, &matrix);
    }
}

hooks! {
    "glUniformMatrix4fv" uniform_matrix4fv(location: i32, count: i32, transpose: u8, value: *const f32) = |ctx, gl| {
        gl.uniform_matrix4fv(location, count, transpose, value);
        if ctx.shaders.pipelines.used != 0 {
            note(ctx.shaders.program.as_deref(), location, count, transpose, value);
        } else {
            note(program_pipelines::active(ctx).as_deref(), location, count, transpose, value);
        }
    };
    "glProgramUniformMatrix4fv" program_uniform_matrix4fv(program: u32, location: i32, count: i32, transpose: u8, value: *const f32) = |ctx, gl| {
        gl.program_uniform_matrix4fv(program, location, count, transpose, value);
        note(programs::record(&ctx.share, program).as_deref(), location, count, transpose, value);
    };
    "glUniformBlockBinding" uniform_block_binding(program: u32, block: u32, binding: u32) = |ctx, gl| {
        gl.uniform_block_binding(program, block, binding);
        programs::read_again(ctx, program);
    };
}
