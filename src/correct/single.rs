//! Where f64 becomes f32, beside the constants of passes.

use glam::DVec3;

/// A pixel of a table: direction and weight, rounded once.
pub(in crate::correct) fn texel(direction: DVec3, weight: f64) -> [f32; 4] {
    [direction.x as f32, direction.y as f32, direction.z as f32, weight as f32]
}
