//! Submission: `vkQueueSubmit`, and the memory that shaders read from then on.
//!
//! [`draw_groups`] goes through the events of the submitted command buffers in order. It decides
//! for each group of draws whether it is of the scene, flat, or flat behind the scene, and writes
//! the view constants of its tiles. [`camera_matrices`] handles the matrices of shaders beside that
//! of the position. [`host_memory`] follows buffers and mapped memory (`vkMapMemory`,
//! `vkBindBufferMemory`, …), so that matrices can be read. [`inspected`] describes groups for
//! `cupola inspect`. State: `Frame`, `HostMemory`.

pub mod backdrops;
pub mod camera_matrices;
pub mod draw_groups;
pub mod host_memory;
pub mod inspected;
pub mod queue;
