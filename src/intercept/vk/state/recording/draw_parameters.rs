//! Parameters of draws in memory that is written when a recorded command buffer runs.

use crate::intercept::vk::state::driver::Driver;
use crate::intercept::vk::state::images::scene_graph::COVERING_VERTICES;
use crate::intercept::vk::state::views::view_constants::{ChunkOffset, ConstantChunk};
use ash::vk;

/// Size of a draw's parameters in bytes, of both kinds.
pub(in crate::intercept::vk) const BYTES: u32 = 20;

/// Parameters of `vkCmdDraw` or `vkCmdDrawIndexed`, in the layout of the indirect commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawParameters {
    /// Numbers of vertices or indices and of instances, and the first ones.
    pub(in crate::intercept::vk) numbers: [u32; 5],
    pub(in crate::intercept::vk) indexed: bool,
}

impl DrawParameters {
    /// Returns the parameters of `vkCmdDraw`.
    pub fn of_vertices(vertices: u32, instances: u32, first_vertex: u32, first_instance: u32) -> Self {
        Self { numbers: [vertices, instances, first_vertex, first_instance, 0], indexed: false }
    }

    /// Returns the parameters of `vkCmdDrawIndexed`.
    pub fn of_indices(indices: u32, instances: u32, first_index: u32, vertex_offset: i32, first_instance: u32) -> Self {
        Self { numbers: [indices, instances, first_index, vertex_offset as u32, first_instance], indexed: true }
    }

    /// Number of vertices that are drawn.
    pub fn vertices(&self) -> u32 {
        self.numbers[0].saturating_mul(self.numbers[1])
    }

    /// Returns the first instance. A value other than 0 needs a feature that the program may not
    /// have enabled.
    pub(in crate::intercept::vk) fn first_instance(&self) -> u32 {
        self.numbers[if self.indexed { 4 } else { 3 }]
    }

    /// Returns the parameters, with no instances if the draw is not in sight.
    pub(in crate::intercept::vk) fn visible(&self, in_sight: bool) -> [u32; 5] {
        let [count, instances, rest @ ..] = self.numbers;
        let [a, b, c] = rest;
        [count, if in_sight { instances } else { 0 }, a, b, c]
    }
}

/// Size of a draw.
#[derive(Clone, Copy)]
pub enum DrawSize {
    /// The program gives it.
    Known(DrawParameters),
    /// Only the device knows it.
    Unknown,
}

impl DrawSize {
    /// Returns the number of vertices, or the largest number if only the device knows it.
    pub fn vertices(&self) -> u32 {
        match self {
            Self::Known(parameters) => parameters.vertices(),
            Self::Unknown => u32::MAX,
        }
    }

    /// Returns the first instance; 0 if only the device knows it.
    pub fn first_instance(&self) -> u32 {
        match self {
            Self::Known(parameters) => parameters.first_instance(),
            Self::Unknown => 0,
        }
    }

    /// True if it has so few vertices that it may be one triangle or square over a viewport.
    pub fn may_cover_viewport(&self) -> bool {
        self.vertices() <= COVERING_VERTICES
    }
}

/// Parameters with their locations in memory, one for each slot of view constants.
#[derive(Clone, Copy, Debug)]
pub struct IndirectDraw {
    pub(in crate::intercept::vk) at: ChunkOffset,
    pub(in crate::intercept::vk) parameters: DrawParameters,
}

impl IndirectDraw {
    /// Writes the parameters for each of `slots` slots.
    pub fn write(&self, chunks: &[ConstantChunk], slots: u32, in_sight: impl Fn(u32) -> bool) {
        let Some(chunk) = chunks.get(self.at.chunk) else { return };
        for slot in 0..slots {
            chunk.write_words(self.at.offset + slot * BYTES, &self.parameters.visible(in_sight(slot)));
        }
    }

    /// Issues the draw with a slot of view constants.
    ///
    /// # Safety
    /// The command buffer is being recorded, and `chunks` are its own.
    pub unsafe fn issue(&self, driver: &Driver, buffer: vk::CommandBuffer, chunks: &[ConstantChunk], slot: u32) {
        let Some(chunk) = chunks.get(self.at.chunk) else { return };
        let (functions, offset) = (&driver.functions, u64::from(self.at.offset + slot * BYTES));
        // SAFETY: as promised; the parameters lie in the chunk, which lives as long as the command
        // buffer needs it.
        unsafe {
            if self.parameters.indexed {
                functions.cmd_draw_indexed_indirect(buffer, chunk.buffer(), offset, 1, BYTES);
            } else {
                functions.cmd_draw_indirect(buffer, chunk.buffer(), offset, 1, BYTES);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::DrawParameters;

    #[test]
    fn what_is_out_of_sight_has_no_instances_and_else_everything() {
        let (vertices, indices) = (DrawParameters::of_vertices(9, 2, 3, 4), DrawParameters::of_indices(9, 2, 3, -4, 5));
        assert_eq!(vertices.visible(true)[..4], [9, 2, 3, 4]);
        assert_eq!(vertices.visible(false)[..4], [9, 0, 3, 4]);
        assert_eq!(indices.visible(true), [9, 2, 3, -4i32 as u32, 5]);
        assert_eq!(indices.visible(false), [9, 0, 3, -4i32 as u32, 5]);
        assert_eq!([vertices.first_instance(), indices.first_instance(), indices.vertices()], [4, 5, 18]);
    }
}
