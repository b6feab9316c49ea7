//! Commands that set a program's matrices. [`refused_locations`] keeps them from Cupola's uniforms.

pub mod refused_locations;

use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::shader::program_pipelines::with_current;
use crate::intercept::gl::shader::programs;
use crate::intercept::gl::shader::uniforms::MOST_NAMED;
use crate::intercept::gl::state::shader::programs::Program;
use crate::intercept::process::call_sum;
use crate::lock::Lock;
use glam::DMat4;

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
    // SAFETY: as promised above.
    unsafe { call_sum::add_values(value, 16 * usize::try_from(count).unwrap_or(0)) };
    let Some(program) = program else { return };
    if location < 0 || count < 1 || value.is_null() {
        return;
    }
    let mut uniforms = program.uniforms.locked();
    let mut camera_matrices = program.has_camera_matrices.then(|| program.camera_matrices.locked());
    for element in 0..count.min(MOST_NAMED as i32) {
        // SAFETY: as promised above.
        let numbers = std::array::from_fn(|i| unsafe { (*value.add(16 * element as usize + i)).into() });
        let matrix = if transpose != 0 { DMat4::from_rows_array(&numbers) } else { DMat4::from_cols_array(&numbers) };
        uniforms.set(location.saturating_add(element), &matrix);
        if let Some(matrices) = &mut camera_matrices {
            matrices.uniforms.set(location.saturating_add(element), &matrix);
        }
    }
}

/// Notes vectors that the program sets.
///
/// # Safety
/// `value` must point at `count` vectors, as the program promises OpenGL.
unsafe fn note_vectors(program: Option<&Program>, location: i32, count: i32, value: *const f32) {
    // SAFETY: as promised above.
    unsafe { call_sum::add_values(value, 4 * usize::try_from(count).unwrap_or(0)) };
    // Most programs set vectors often, and have no matrix that consists of them.
    let Some(program) = program.filter(|program| program.has_vectors) else { return };
    if location < 0 || count < 1 || value.is_null() {
        return;
    }
    let mut uniforms = program.uniforms.locked();
    for number in 0..count {
        // SAFETY: as promised above.
        let vector = unsafe { value.cast::<[f32; 4]>().add(number as usize).read_unaligned() };
        uniforms.set_vector(location.saturating_add(number), vector);
    }
}

hooks! {
    "glUniformMatrix4fv" uniform_matrix4fv(location: i32, count: i32, transpose: u8, value: *const f32) = |ctx, gl| {
        gl.uniform_matrix4fv(refused_locations::in_use(ctx, location), count, transpose, value);
        with_current(&ctx.share, &ctx.shaders, |program| note(program, location, count, transpose, value));
    };
    "glUniformMatrix4dv" uniform_matrix4dv(location: i32, count: i32, transpose: u8, value: *const f64) = |ctx, gl| {
        gl.uniform_matrix4dv(refused_locations::in_use(ctx, location), count, transpose, value);
        with_current(&ctx.share, &ctx.shaders, |program| note(program, location, count, transpose, value));
    };
    "glUniform4fv" uniform4fv(location: i32, count: i32, value: *const f32) = |ctx, gl| {
        gl.uniform4fv(refused_locations::in_use(ctx, location), count, value);
        with_current(&ctx.share, &ctx.shaders, |program| note_vectors(program, location, count, value));
    };
    "glUniform4f" uniform4f(location: i32, x: f32, y: f32, z: f32, w: f32) = |ctx, gl| {
        gl.uniform4f(refused_locations::in_use(ctx, location), x, y, z, w);
        with_current(&ctx.share, &ctx.shaders, |program| note_vectors(program, location, 1, [x, y, z, w].as_ptr()));
    };
    "glProgramUniform4fv" program_uniform4fv(program: u32, location: i32, count: i32, value: *const f32) = |ctx, gl| {
        let (program, location) = refused_locations::of(&ctx.share, program, location);
        gl.program_uniform4fv(program, location, count, value);
        note_vectors(programs::record(&ctx.share, program).as_deref(), location, count, value);
    };
    "glProgramUniform4f" program_uniform4f(program: u32, location: i32, x: f32, y: f32, z: f32, w: f32) = |ctx, gl| {
        let (program, location) = refused_locations::of(&ctx.share, program, location);
        gl.program_uniform4f(program, location, x, y, z, w);
        note_vectors(programs::record(&ctx.share, program).as_deref(), location, 1, [x, y, z, w].as_ptr());
    };
    "glProgramUniformMatrix4dv" program_uniform_matrix4dv(program: u32, location: i32, count: i32, transpose: u8, value: *const f64) = |ctx, gl| {
        let (program, location) = refused_locations::of(&ctx.share, program, location);
        gl.program_uniform_matrix4dv(program, location, count, transpose, value);
        note(programs::record(&ctx.share, program).as_deref(), location, count, transpose, value);
    };
    "glProgramUniformMatrix4fv" program_uniform_matrix4fv(program: u32, location: i32, count: i32, transpose: u8, value: *const f32) = |ctx, gl| {
        let (program, location) = refused_locations::of(&ctx.share, program, location);
        gl.program_uniform_matrix4fv(program, location, count, transpose, value);
        note(programs::record(&ctx.share, program).as_deref(), location, count, transpose, value);
    };
    "glUniformBlockBinding" uniform_block_binding(program: u32, block: u32, binding: u32) = |ctx, gl| {
        gl.uniform_block_binding(programs::asked(&ctx.share, program), block, binding);
        programs::read_again(&ctx.share, &ctx.driver, program);
    };
    "glShaderStorageBlockBinding" shader_storage_block_binding(program: u32, block: u32, binding: u32) = |ctx, gl| {
        gl.shader_storage_block_binding(programs::asked(&ctx.share, program), block, binding);
        programs::read_again(&ctx.share, &ctx.driver, program);
    };
}
