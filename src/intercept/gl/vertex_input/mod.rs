//! TODO-NOTE

pub mod buffer_bindings;
pub mod buffers;
pub mod vertex_array_commands;
pub mod vertex_arrays;
