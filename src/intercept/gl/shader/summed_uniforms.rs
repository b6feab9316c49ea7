//! Uniforms that Cupola does not use. They have hooks only if several machines compare the calls of
//! their programs.

use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::process::call_sum::add_values;

/// Number of values in this number of vectors of `length`.
fn values(count: i32, length: usize) -> usize {
    length * usize::try_from(count).unwrap_or(0)
}

/// Hooks that pass the call on. `hooks!` adds the numbers to the checksum before.
macro_rules! uniforms {
    (
        $( $name:literal $method:ident ( $($p:ident : $t:ty),* ); )*
        vectors: $( $vector:literal $set:ident $kind:ty, $length:literal; )*
        matrices: $( $matrix:literal $load:ident $size:literal; )*
    ) => {
        hooks! {
            $( $name $method(location: i32, $($p: $t),*) = |_ctx, gl| gl.$method(location, $($p),*); )*
            $( $vector $set(location: i32, count: i32, value: *const $kind) = |_ctx, gl| {
                add_values(value, values(count, $length));
                gl.$set(location, count, value);
            }; )*
            $( $matrix $load(location: i32, count: i32, transpose: u8, value: *const f32) = |_ctx, gl| {
                add_values(value, values(count, $size));
                gl.$load(location, count, transpose, value);
            }; )*
        }
    };
}

uniforms! {
    "glUniform1f" uniform1f(x: f32);
    "glUniform2f" uniform2f(x: f32, y: f32);
    "glUniform3f" uniform3f(x: f32, y: f32, z: f32);
    "glUniform1i" uniform1i(x: i32);
    "glUniform2i" uniform2i(x: i32, y: i32);
    "glUniform3i" uniform3i(x: i32, y: i32, z: i32);
    "glUniform4i" uniform4i(x: i32, y: i32, z: i32, w: i32);
    "glUniform1ui" uniform1ui(x: u32);
    vectors:
    "glUniform1fv" uniform1fv f32, 1;
    "glUniform2fv" uniform2fv f32, 2;
    "glUniform3fv" uniform3fv f32, 3;
    "glUniform1iv" uniform1iv i32, 1;
    "glUniform2iv" uniform2iv i32, 2;
    "glUniform3iv" uniform3iv i32, 3;
    "glUniform4iv" uniform4iv i32, 4;
    matrices:
    "glUniformMatrix2fv" uniform_matrix2fv 4;
    "glUniformMatrix3fv" uniform_matrix3fv 9;
}
