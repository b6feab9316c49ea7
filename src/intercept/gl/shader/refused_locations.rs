//! Commands that set uniforms or ask for their values. They cannot reach Cupola's own uniforms:
//! OpenGL refuses the location of one as it does without Cupola, where no uniform has it.
//!
//! Commands that set what may be a matrix are in [`uniform_commands`].
//!
//! [`uniform_commands`]: crate::intercept::gl::shader::uniform_commands

use crate::intercept::gl::context::gl_context::{Context, ShareGroup};
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::shader::programs;
use crate::intercept::gl::shader::uniform_commands::with_current;
use crate::intercept::process::call_sum::add_values;

/// A location that no program has.
const NOWHERE: i32 = i32::MAX;

/// Returns the location for the driver, in the program that `glUniform` sets.
pub(super) fn in_use(ctx: &Context, location: i32) -> i32 {
    // A list that is compiled sets uniforms of a program that is not known yet.
    let refused = !ctx.compiling()
        && with_current(&ctx.share, &ctx.shaders, |program| program.is_some_and(|program| program.refuses(location)));
    if refused { NOWHERE } else { location }
}

/// Returns the program and the location for the driver.
pub(super) fn of(share: &ShareGroup, program: u32, location: i32) -> (u32, i32) {
    match programs::record(share, program) {
        Some(record) if record.refuses(location) => (record.asked(), NOWHERE),
        _ => (program, location),
    }
}

/// Returns the number of values in this number of vectors of `length`.
fn values(count: i32, length: usize) -> usize {
    length * usize::try_from(count).unwrap_or(0)
}

/// Hooks that pass the call on. `hooks!` adds the numbers to the checksum of calls before.
macro_rules! uniforms {
    (
        $( $name:literal $method:ident $by_name:literal $with_name:ident ( $($p:ident : $t:ty),* ); )*
        vectors: $( $vector:literal $set:ident $vector_by_name:literal $set_with_name:ident $kind:ty, $length:literal; )*
        questions: $( $question:literal $get:ident $bounded:literal $get_bounded:ident $answer:ty; )*
        matrices: $( $matrix:literal $load:ident $matrix_by_name:literal $load_with_name:ident $number:ty, $size:literal; )*
    ) => {
        hooks! {
            $( $name $method(location: i32, $($p: $t),*) = |ctx, gl| gl.$method(in_use(ctx, location), $($p),*); )*
            $( $by_name $with_name(program: u32, location: i32, $($p: $t),*) = |ctx, gl| {
                let (program, location) = of(&ctx.share, program, location);
                gl.$with_name(program, location, $($p),*);
            }; )*
            $( $vector $set(location: i32, count: i32, value: *const $kind) = |ctx, gl| {
                add_values(value, values(count, $length));
                gl.$set(in_use(ctx, location), count, value);
            }; )*
            $( $vector_by_name $set_with_name(program: u32, location: i32, count: i32, value: *const $kind) = |ctx, gl| {
                add_values(value, values(count, $length));
                let (program, location) = of(&ctx.share, program, location);
                gl.$set_with_name(program, location, count, value);
            }; )*
            $( $question $get(program: u32, location: i32, values: *mut $answer) = |ctx, gl| {
                let (program, location) = of(&ctx.share, program, location);
                gl.$get(program, location, values);
            }; )*
            $( $bounded $get_bounded(program: u32, location: i32, room: i32, values: *mut $answer) = |ctx, gl| {
                let (program, location) = of(&ctx.share, program, location);
                gl.$get_bounded(program, location, room, values);
            }; )*
            $( $matrix $load(location: i32, count: i32, transpose: u8, value: *const $number) = |ctx, gl| {
                add_values(value, values(count, $size));
                gl.$load(in_use(ctx, location), count, transpose, value);
            }; )*
            $( $matrix_by_name $load_with_name(program: u32, location: i32, count: i32, transpose: u8, value: *const $number) = |ctx, gl| {
                add_values(value, values(count, $size));
                let (program, location) = of(&ctx.share, program, location);
                gl.$load_with_name(program, location, count, transpose, value);
            }; )*
        }
    };
}

uniforms! {
    "glUniform1f" uniform1f "glProgramUniform1f" program_uniform1f (x: f32);
    "glUniform1i" uniform1i "glProgramUniform1i" program_uniform1i (x: i32);
    "glUniform1ui" uniform1ui "glProgramUniform1ui" program_uniform1ui (x: u32);
    "glUniform1d" uniform1d "glProgramUniform1d" program_uniform1d (x: f64);
    "glUniform2f" uniform2f "glProgramUniform2f" program_uniform2f (x: f32, y: f32);
    "glUniform2i" uniform2i "glProgramUniform2i" program_uniform2i (x: i32, y: i32);
    "glUniform2ui" uniform2ui "glProgramUniform2ui" program_uniform2ui (x: u32, y: u32);
    "glUniform2d" uniform2d "glProgramUniform2d" program_uniform2d (x: f64, y: f64);
    "glUniform3f" uniform3f "glProgramUniform3f" program_uniform3f (x: f32, y: f32, z: f32);
    "glUniform3i" uniform3i "glProgramUniform3i" program_uniform3i (x: i32, y: i32, z: i32);
    "glUniform3ui" uniform3ui "glProgramUniform3ui" program_uniform3ui (x: u32, y: u32, z: u32);
    "glUniform3d" uniform3d "glProgramUniform3d" program_uniform3d (x: f64, y: f64, z: f64);
    "glUniform4i" uniform4i "glProgramUniform4i" program_uniform4i (x: i32, y: i32, z: i32, w: i32);
    "glUniform4ui" uniform4ui "glProgramUniform4ui" program_uniform4ui (x: u32, y: u32, z: u32, w: u32);
    "glUniform4d" uniform4d "glProgramUniform4d" program_uniform4d (x: f64, y: f64, z: f64, w: f64);
    vectors:
    "glUniform1fv" uniform1fv "glProgramUniform1fv" program_uniform1fv f32, 1;
    "glUniform1iv" uniform1iv "glProgramUniform1iv" program_uniform1iv i32, 1;
    "glUniform1uiv" uniform1uiv "glProgramUniform1uiv" program_uniform1uiv u32, 1;
    "glUniform1dv" uniform1dv "glProgramUniform1dv" program_uniform1dv f64, 1;
    "glUniform2fv" uniform2fv "glProgramUniform2fv" program_uniform2fv f32, 2;
    "glUniform2iv" uniform2iv "glProgramUniform2iv" program_uniform2iv i32, 2;
    "glUniform2uiv" uniform2uiv "glProgramUniform2uiv" program_uniform2uiv u32, 2;
    "glUniform2dv" uniform2dv "glProgramUniform2dv" program_uniform2dv f64, 2;
    "glUniform3fv" uniform3fv "glProgramUniform3fv" program_uniform3fv f32, 3;
    "glUniform3iv" uniform3iv "glProgramUniform3iv" program_uniform3iv i32, 3;
    "glUniform3uiv" uniform3uiv "glProgramUniform3uiv" program_uniform3uiv u32, 3;
    "glUniform3dv" uniform3dv "glProgramUniform3dv" program_uniform3dv f64, 3;
    "glUniform4iv" uniform4iv "glProgramUniform4iv" program_uniform4iv i32, 4;
    "glUniform4uiv" uniform4uiv "glProgramUniform4uiv" program_uniform4uiv u32, 4;
    "glUniform4dv" uniform4dv "glProgramUniform4dv" program_uniform4dv f64, 4;
    questions:
    "glGetUniformfv" get_uniformfv "glGetnUniformfv" getn_uniformfv f32;
    "glGetUniformiv" get_uniformiv "glGetnUniformiv" getn_uniformiv i32;
    "glGetUniformuiv" get_uniformuiv "glGetnUniformuiv" getn_uniformuiv u32;
    "glGetUniformdv" get_uniformdv "glGetnUniformdv" getn_uniformdv f64;
    matrices:
    "glUniformMatrix2fv" uniform_matrix2fv "glProgramUniformMatrix2fv" program_uniform_matrix2fv f32, 4;
    "glUniformMatrix2dv" uniform_matrix2dv "glProgramUniformMatrix2dv" program_uniform_matrix2dv f64, 4;
    "glUniformMatrix3fv" uniform_matrix3fv "glProgramUniformMatrix3fv" program_uniform_matrix3fv f32, 9;
    "glUniformMatrix3dv" uniform_matrix3dv "glProgramUniformMatrix3dv" program_uniform_matrix3dv f64, 9;
    "glUniformMatrix2x3fv" uniform_matrix2x3fv "glProgramUniformMatrix2x3fv" program_uniform_matrix2x3fv f32, 6;
    "glUniformMatrix2x3dv" uniform_matrix2x3dv "glProgramUniformMatrix2x3dv" program_uniform_matrix2x3dv f64, 6;
    "glUniformMatrix2x4fv" uniform_matrix2x4fv "glProgramUniformMatrix2x4fv" program_uniform_matrix2x4fv f32, 8;
    "glUniformMatrix2x4dv" uniform_matrix2x4dv "glProgramUniformMatrix2x4dv" program_uniform_matrix2x4dv f64, 8;
    "glUniformMatrix3x2fv" uniform_matrix3x2fv "glProgramUniformMatrix3x2fv" program_uniform_matrix3x2fv f32, 6;
    "glUniformMatrix3x2dv" uniform_matrix3x2dv "glProgramUniformMatrix3x2dv" program_uniform_matrix3x2dv f64, 6;
    "glUniformMatrix3x4fv" uniform_matrix3x4fv "glProgramUniformMatrix3x4fv" program_uniform_matrix3x4fv f32, 12;
    "glUniformMatrix3x4dv" uniform_matrix3x4dv "glProgramUniformMatrix3x4dv" program_uniform_matrix3x4dv f64, 12;
    "glUniformMatrix4x2fv" uniform_matrix4x2fv "glProgramUniformMatrix4x2fv" program_uniform_matrix4x2fv f32, 8;
    "glUniformMatrix4x2dv" uniform_matrix4x2dv "glProgramUniformMatrix4x2dv" program_uniform_matrix4x2dv f64, 8;
    "glUniformMatrix4x3fv" uniform_matrix4x3fv "glProgramUniformMatrix4x3fv" program_uniform_matrix4x3fv f32, 12;
    "glUniformMatrix4x3dv" uniform_matrix4x3dv "glProgramUniformMatrix4x3dv" program_uniform_matrix4x3dv f64, 12;
}
