//! Records of buffers and vertex arrays.
//!
//! Hooks of the commands that write to buffers are in [`buffers`] and [`named_buffers_ext`], those
//! that bind buffers in [`buffer_bindings`], those that set vertex arrays in
//! [`vertex_array_commands`]. [`vertex_arrays`] asks the driver once for the state that a draw
//! needs, and keeps it until a call changes it. [`ranges`] keeps boxes around vertices in buffers.

pub mod buffer_bindings;
pub mod buffers;
pub mod named_buffers_ext;
pub mod position_layout;
pub mod ranges;
pub mod vertex_array_commands;
pub mod vertex_arrays;
