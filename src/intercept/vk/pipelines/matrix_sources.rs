//! Matrices that shaders read: their locations and values.

use crate::intercept::scene::lens;
use crate::intercept::vk::spirv::{Matrix, Memory};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::recording::Recording;
use crate::intercept::vk::state::recording::bindings::BoundSet;
use crate::intercept::vk::state::recording::draw_groups::{MatrixSource, MatrixValue};

/// Reads a matrix from memory.
pub fn matrix(device: &Device, source: &MatrixSource) -> Option<[f64; 16]> {
    let raw = match source.value {
        MatrixValue::Known(raw) => raw,
        MatrixValue::Buffer(buffer, offset) => {
            let stride = source.matrix.stride as usize;
            let mut bytes = [0; 256];
            let bytes = bytes.get_mut(..3 * stride + 16)?;
            if !device.host_memory.read(buffer, offset, bytes) {
                return None;
            }
            from_bytes(bytes, stride)?
        }
    };
    let value = raw.map(f64::from);
    Some(if source.matrix.row_major { lens::transposed(&value) } else { value })
}

/// Reads sixteen floats in four groups of four, with a distance of `stride` bytes between the
/// groups.
pub fn from_bytes(bytes: &[u8], stride: usize) -> Option<[f32; 16]> {
    let mut raw = [0.0; 16];
    for (i, value) in raw.iter_mut().enumerate() {
        let at = i / 4 * stride + i % 4 * 4;
        *value = f32::from_ne_bytes(bytes.get(at..at + 4)?.try_into().ok()?);
    }
    Some(raw)
}

/// Returns the location of a shader's matrix, in the descriptors and push constants that are bound.
pub fn source(device: &Device, recording: &Recording, matrix: &Matrix) -> Option<MatrixSource> {
    let bound = |set: u32| recording.graphics.bound.get(set as usize)?.as_ref();
    source_of(device, &recording.graphics.push, bound, matrix)
}

/// As [`source`], for a compute shader.
pub fn compute_source(device: &Device, recording: &Recording, matrix: &Matrix) -> Option<MatrixSource> {
    source_of(device, recording.compute.pushed(), |set| recording.compute.set(set), matrix)
}

fn source_of<'a>(
    device: &Device,
    push: &[u8],
    bound: impl Fn(u32) -> Option<&'a BoundSet>,
    matrix: &Matrix,
) -> Option<MatrixSource> {
    let value = match matrix.memory {
        Memory::Push => MatrixValue::Known(from_bytes(push.get(matrix.offset as usize..)?, matrix.stride as usize)?),
        Memory::Buffer { set, binding } => {
            let bound = bound(set)?;
            let (buffer, offset) = bound.buffer(&device.descriptors, binding)?;
            MatrixValue::Buffer(buffer, offset + u64::from(matrix.offset))
        }
    };
    Some(MatrixSource { matrix: *matrix, value })
}

#[cfg(test)]
mod tests {
    use super::from_bytes;

    #[test]
    fn numbers_are_read_by_their_stride() {
        let mut bytes = vec![0; 3 * 32 + 16];
        bytes[2 * 32 + 4..2 * 32 + 8].copy_from_slice(&7f32.to_ne_bytes());
        assert_eq!(from_bytes(&bytes, 32).map(|m| m[9]), Some(7.0));
        assert_eq!(from_bytes(&bytes[..90], 32), None);
    }
}
