//! The only place where f64 becomes f32: every coefficient is computed in f64 and rounded once.

use glam::{DMat3, DMat4, DVec3, Mat4};

/// Rounds a number.
pub(in crate::correct) fn value(exact: f64) -> f32 {
    exact as f32
}

/// Rounds numbers.
pub fn values<const N: usize>(exact: [f64; N]) -> [f32; N] {
    exact.map(|value| value as f32)
}

/// Rounds a matrix, column by column.
pub(in crate::correct) fn matrix3(exact: DMat3) -> [f32; 9] {
    values(exact.to_cols_array())
}

/// Rounds a matrix.
pub fn matrix4(exact: &DMat4) -> Mat4 {
    exact.as_mat4()
}

/// Converts a length in pixels; exact below 2^24.
pub fn pixels(length: i32) -> f32 {
    length as f32
}

/// Rounds a pixel of a table: direction and weight.
pub(in crate::correct) fn texel(direction: DVec3, weight: f64) -> [f32; 4] {
    [direction.x as f32, direction.y as f32, direction.z as f32, weight as f32]
}
