//! TODO-NOTE

pub mod buffer_bindings;
pub mod buffers;
pub mod position_layout;
pub mod ranges;
pub mod uniform_blocks;
pub mod vertex_array_commands;
pub mod vertex_arrays;
