//! The compatibility profile.
//!
//! Answers Begin/End and its commands ([`begin_end`], [`vertex_commands`]), display lists
//! ([`display_lists`]), matrix commands ([`matrices`]) and the raster position
//! ([`raster_position`], [`scene_position`]). A Begin/End is recorded and then issued like any
//! other draw. A display list is split into lists of the driver; between them are the commands that
//! run once and not once per view. `context::list_recording` records both, this room runs them.

pub mod begin_end;
pub mod display_lists;
pub mod list_calls;
pub mod matrices;
pub mod raster_position;
pub mod scene_position;
pub mod vertex_commands;
