//! Parts of the description of a view that OpenGL and Vulkan share.

use super::argument::{Place, array, copy_text};
use crate::correct::single;
use crate::error::Result;
use glam::DMat4;
use std::ffi::c_char;

/// Matrices of a view, in both precisions.
pub(super) struct Matrices {
    pub(super) projection: [f32; 16],
    pub(super) rotation: [f32; 16],
    pub(super) frustum: [f32; 16],
    pub(super) projection_f64: [f64; 16],
    pub(super) rotation_f64: [f64; 16],
    pub(super) frustum_f64: [f64; 16],
}

impl Matrices {
    /// Takes the matrix from the axes of the view to clip space, and the one from the program's
    /// camera axes to those of the view.
    pub(super) fn new(frustum: DMat4, rotation: DMat4) -> Self {
        let projection = frustum * rotation;
        Self {
            projection: single::matrix4(&projection).to_cols_array(),
            rotation: single::matrix4(&rotation).to_cols_array(),
            frustum: single::matrix4(&frustum).to_cols_array(),
            projection_f64: projection.to_cols_array(),
            rotation_f64: rotation.to_cols_array(),
            frustum_f64: frustum.to_cols_array(),
        }
    }
}

/// Name as in the structs: NUL-terminated, cut to 31 bytes between characters.
pub(super) fn name_of(name: &str) -> [c_char; 32] {
    let mut held = [0; 32];
    // SAFETY: room for 32 bytes; null is allowed for the length.
    unsafe { copy_text(name, held.as_mut_ptr(), held.len(), std::ptr::null_mut()) };
    held
}

/// Computes the vectors of `cupola_view` for the program's `matrix`, and writes them.
///
/// # Safety
/// `matrix` is null or points to 16 numbers, `vectors` is null or has room for 32.
pub(super) unsafe fn get_projection(
    matrix: *const f32,
    vectors: *mut f32,
    find: impl FnOnce(&DMat4) -> Result<[f32; 32]>,
) -> Result<()> {
    // SAFETY: as this function's contract.
    let (matrix, vectors) =
        unsafe { (array::<f32, 16>(matrix, "matrix")?, Place::new(vectors.cast::<[f32; 32]>(), "vectors")?) };
    vectors.set(find(&DMat4::from_cols_array(&matrix.map(f64::from)))?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_ends_with_a_whole_character() {
        let shown = |name: &str| String::from_utf8(name_of(name).map(|byte| byte as u8).to_vec());
        assert_eq!(shown("front").as_deref(), Ok(&*format!("front{}", "\0".repeat(27))));
        assert_eq!(shown(&"a".repeat(40)).as_deref(), Ok(&*format!("{}\0", "a".repeat(31))));
        assert_eq!(shown(&"ü".repeat(16)).as_deref(), Ok(&*format!("{}\0\0", "ü".repeat(15))));
    }
}
