//! Matrices that shaders read: their locations and values.

use crate::intercept::scene::flat_program::MissingLens;
use crate::intercept::vk::spirv::{self, Matrix, Memory};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::pipelines::InstanceColumn;
use crate::intercept::vk::state::pipelines::stages::words_of;
use crate::intercept::vk::state::recording::bindings::BoundSet;
use crate::intercept::vk::state::recording::draw_groups::{MatrixSource, MatrixValue};
use crate::intercept::vk::state::recording::{GraphicsState, Recording};
use ash::vk;
use glam::{DMat4, Mat4};

/// Reads a matrix from memory.
pub fn matrix(device: &Device, source: &MatrixSource) -> Option<DMat4> {
    let raw = match source.value {
        MatrixValue::Known(raw) => raw,
        MatrixValue::Buffer(buffer, offset) => from_buffer(device, buffer, offset, source.matrix.stride)?,
        MatrixValue::AtAddress(buffer, at, offset) => {
            let mut address = [0; 8];
            if !device.host_memory.read(buffer, at, &mut address) {
                return None;
            }
            let (buffer, start) = device.host_memory.at_address(u64::from_ne_bytes(address))?;
            from_buffer(device, buffer, start.checked_add(offset)?, source.matrix.stride)?
        }
    };
    let value = raw.as_dmat4();
    Some(if source.matrix.row_major { value.transpose() } else { value })
}

/// Reads a matrix from a buffer.
fn from_buffer(device: &Device, buffer: vk::Buffer, offset: u64, stride: u32) -> Option<Mat4> {
    let stride = stride as usize;
    let mut bytes = [0; 256];
    let bytes = bytes.get_mut(..3 * stride + 16)?;
    device.host_memory.read(buffer, offset, bytes).then(|| from_bytes(bytes, stride))?
}

/// Reads a matrix whose columns have a distance of `stride` bytes.
pub fn from_bytes(bytes: &[u8], stride: usize) -> Option<Mat4> {
    let mut columns = [[0.0; 4]; 4];
    for (number, column) in columns.iter_mut().enumerate() {
        for (row, entry) in column.iter_mut().enumerate() {
            let at = number * stride + row * size_of::<f32>();
            *entry = f32::from_ne_bytes(bytes.get(at..at + size_of::<f32>())?.try_into().ok()?);
        }
    }
    Some(Mat4::from_cols_array_2d(&columns))
}

/// True if the only stage before rasterisation computes positions from numbers of its own.
///
/// # Safety
/// `stages` must be the program's.
pub unsafe fn has_fixed_position(device: &Device, stages: &[vk::PipelineShaderStageCreateInfo<'_>]) -> bool {
    let mut before = stages.iter().filter(|stage| stage.stage != vk::ShaderStageFlags::FRAGMENT);
    let (Some(stage), None) = (before.next(), before.next()) else { return false };
    // SAFETY: as promised.
    let words = unsafe { words_of(device, stage) };
    words.is_some_and(|words| spirv::has_fixed_position(&words))
}

/// Returns the matrices that the stages before rasterisation read, and the reason why there is no
/// lens if there are none. Attributes count if no other matrix makes the position. `columns`: those
/// that are of instances.
///
/// # Safety
/// `stages` must be the program's.
pub unsafe fn before_rasterisation(
    device: &Device,
    stages: &[vk::PipelineShaderStageCreateInfo<'_>],
    columns: &[InstanceColumn],
) -> (Vec<Matrix>, MissingLens) {
    let locations: Vec<u32> = columns.iter().map(|column| column.location).collect();
    let before = || stages.iter().filter(|stage| stage.stage != vk::ShaderStageFlags::FRAGMENT);
    // The bits of the stages are in the order of the stages.
    let last = before().map(|stage| stage.stage).max();
    let (mut matrices, mut attributes) = (Vec::new(), Vec::new());
    let mut missing = MissingLens::default();
    for stage in before() {
        let of_position = Some(stage.stage) == last;
        // SAFETY: as promised.
        let Some(words) = (unsafe { words_of(device, stage) }) else { continue };
        matrices.extend(spirv::matrices(&words, of_position));
        if stage.stage == vk::ShaderStageFlags::VERTEX {
            attributes.extend(spirv::attribute_matrices(&words, of_position, &locations));
        }
        if matrices.is_empty() && !attributes.iter().any(|attribute| attribute.memory.has_matrix()) {
            missing = missing.max(spirv::missing_lens(&words));
        }
    }
    if matrices.is_empty() && !attributes.is_empty() {
        device.host_memory.keep_vertices();
        let declared = attributes.iter().any(|attribute| attribute.memory.has_matrix());
        return (attributes, if declared { MissingLens::Attribute } else { missing });
    }
    (matrices, missing)
}

/// Returns the location of a shader's matrix, in the descriptors, push constants and vertex buffers
/// that are bound. `first_instance`: of a draw with the bound pipeline.
pub fn source(device: &Device, recording: &Recording, matrix: &Matrix, first_instance: u32) -> Option<MatrixSource> {
    if let Memory::Attribute { location, .. } = matrix.memory {
        return of_instance(&recording.graphics, matrix, location, first_instance);
    }
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
        Memory::Attribute { .. } => return None,
        Memory::PushedAddress { at } => {
            let address = push.get(at as usize..at as usize + 8)?.try_into().ok()?;
            let (buffer, start) = device.host_memory.at_address(u64::from_ne_bytes(address))?;
            MatrixValue::Buffer(buffer, start + u64::from(matrix.offset))
        }
        Memory::AddressInBuffer { set, binding, at } => {
            let (buffer, offset) = bound(set)?.buffer(&device.descriptors, binding)?;
            MatrixValue::AtAddress(buffer, offset + u64::from(at), matrix.offset.into())
        }
        Memory::Push => MatrixValue::Known(from_bytes(push.get(matrix.offset as usize..)?, matrix.stride as usize)?),
        Memory::Buffer { set, binding } => {
            let bound = bound(set)?;
            let (buffer, offset) = bound.buffer(&device.descriptors, binding)?;
            MatrixValue::Buffer(buffer, offset + u64::from(matrix.offset))
        }
    };
    Some(MatrixSource { matrix: *matrix, value })
}

/// Returns the location of a matrix whose columns are attributes of the first instance; `None` if
/// the columns are not in one buffer, equally far from each other.
fn of_instance(graphics: &GraphicsState, matrix: &Matrix, location: u32, first: u32) -> Option<MatrixSource> {
    let pipeline = graphics.pipeline.as_ref()?;
    let column = |number: u32| pipeline.columns.iter().find(|c| Some(c.location) == location.checked_add(number));
    let [x, y, z, w] = [column(0)?, column(1)?, column(2)?, column(3)?];
    let distance = y.offset.checked_sub(x.offset)?;
    let follow = |(one, next): (&InstanceColumn, &InstanceColumn)| {
        one.binding == next.binding && one.offset.checked_add(distance) == Some(next.offset)
    };
    let bound = (*graphics.vertices.get(x.binding as usize)?)?;
    let instances = bound.stride.unwrap_or(x.stride.into()).checked_mul(first.into())?;
    let offset = bound.offset.checked_add(instances)?.checked_add(x.offset.into())?;
    let matrix = Matrix { stride: distance, ..*matrix };
    let value = MatrixValue::Buffer(bound.buffer, offset);
    [(x, y), (y, z), (z, w)].into_iter().all(follow).then_some(MatrixSource { matrix, value })
}

#[cfg(test)]
mod tests {
    use super::from_bytes;

    #[test]
    fn numbers_are_read_by_their_stride() {
        let mut bytes = vec![0; 3 * 32 + 16];
        bytes[2 * 32 + 4..2 * 32 + 8].copy_from_slice(&7f32.to_ne_bytes());
        assert_eq!(from_bytes(&bytes, 32).map(|m| m.z_axis.y), Some(7.0));
        assert_eq!(from_bytes(&bytes[..90], 32), None);
    }
}
