//! Parameters of draws in memory that is written when a recorded command buffer runs.

use crate::intercept::vk::state::driver::Driver;
use crate::intercept::vk::state::view_constants::{Piece, Place};
use ash::vk;

/// Bytes of a draw's parameters, of either kind.
pub(in crate::intercept::vk) const BYTES: u32 = 20;

/// What `vkCmdDraw` and `vkCmdDrawIndexed` are told, as memory has it for their indirect kinds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Vertices or indices, instances, and what comes first.
    pub(in crate::intercept::vk) numbers: [u32; 5],
    pub(in crate::intercept::vk) indexed: bool,
}

impl Parameters {
    /// Of `vkCmdDraw`.
    pub fn of_vertices(vertices: u32, instances: u32, first_vertex: u32, first_instance: u32) -> Self {
        Self { numbers: [vertices, instances, first_vertex, first_instance, 0], indexed: false }
    }

    /// Of `vkCmdDrawIndexed`.
    pub fn of_indices(indices: u32, instances: u32, first_index: u32, vertex_offset: i32, first_instance: u32) -> Self {
        Self { numbers: [indices, instances, first_index, vertex_offset as u32, first_instance], indexed: true }
    }

    /// How many vertices are drawn.
    pub fn vertices(&self) -> u32 {
        self.numbers[0].saturating_mul(self.numbers[1])
    }

    /// Other instances than the first ones need a feature that the program may not have asked for.
    pub(in crate::intercept::vk) fn first_instance(&self) -> u32 {
        self.numbers[if self.indexed { 4 } else { 3 }]
    }

    /// The same, or the same for no instances.
    pub(in crate::intercept::vk) fn shown(&self, in_sight: bool) -> [u32; 5] {
        let [count, instances, rest @ ..] = self.numbers;
        let [a, b, c] = rest;
        [count, if in_sight { instances } else { 0 }, a, b, c]
    }
}

/// Parameters with their places in memory, one for each group of rows.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    pub(in crate::intercept::vk) place: Place,
    pub(in crate::intercept::vk) parameters: Parameters,
}

impl Placed {
    /// Writes what is drawn with each of so many groups.
    pub fn write(&self, pieces: &[Piece], groups: u32, in_sight: impl Fn(u32) -> bool) {
        let Some(piece) = pieces.get(self.place.piece) else { return };
        for group in 0..groups {
            piece.write_words(self.place.offset + group * BYTES, &self.parameters.shown(in_sight(group)));
        }
    }

    /// Issues the draw with a group of rows.
    ///
    /// # Safety
    /// The command buffer is being recorded, and `pieces` are its own.
    pub unsafe fn issue(&self, driver: &Driver, buffer: vk::CommandBuffer, pieces: &[Piece], group: u32) {
        let Some(piece) = pieces.get(self.place.piece) else { return };
        let (functions, offset) = (&driver.functions, u64::from(self.place.offset + group * BYTES));
        // SAFETY: as promised; the parameters lie in the piece, which lives as long as the command buffer needs it.
        unsafe {
            if self.parameters.indexed {
                functions.cmd_draw_indexed_indirect(buffer, piece.buffer(), offset, 1, BYTES);
            } else {
                functions.cmd_draw_indirect(buffer, piece.buffer(), offset, 1, BYTES);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Parameters;

    #[test]
    fn what_is_out_of_sight_has_no_instances_and_else_everything() {
        let (vertices, indices) = (Parameters::of_vertices(9, 2, 3, 4), Parameters::of_indices(9, 2, 3, -4, 5));
        assert_eq!(vertices.shown(true)[..4], [9, 2, 3, 4]);
        assert_eq!(vertices.shown(false)[..4], [9, 0, 3, 4]);
        assert_eq!(indices.shown(true), [9, 2, 3, -4i32 as u32, 5]);
        assert_eq!(indices.shown(false), [9, 0, 3, -4i32 as u32, 5]);
        assert_eq!([vertices.first_instance(), indices.first_instance(), indices.vertices()], [4, 5, 18]);
    }
}
