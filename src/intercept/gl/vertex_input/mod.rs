//! Records of buffers and vertex arrays.
//!
//! Answers the commands that write to buffers ([`buffers`], [`named_buffers_ext`]), bind them
//! ([`buffer_bindings`]) and set vertex arrays ([`vertex_array_commands`]). [`vertex_arrays`] asks
//! the driver once for what a draw needs and keeps it until a call changes it; [`ranges`] keeps
//! boxes around vertices in buffers.

pub mod buffer_bindings;
pub mod buffers;
pub mod named_buffers_ext;
pub mod position_layout;
pub mod ranges;
pub mod vertex_array_commands;
pub mod vertex_arrays;
