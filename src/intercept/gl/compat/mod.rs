//! The compatibility profile.
//!
//! Hooks of Begin/End and its commands are in [`begin_end`] and [`vertex_commands`], those of
//! display lists in [`display_lists`], those of matrices in [`matrices`], those of the raster
//! position in [`raster_position`] and [`scene_position`]. A Begin/End is recorded and then issued
//! like any other draw. A display list is split into lists of the driver; between them are the
//! commands that run once and not once per view. `context::list_recording` records both, this
//! folder runs them.

pub mod begin_end;
pub mod display_lists;
pub mod list_calls;
pub mod matrices;
pub mod raster_position;
pub mod scene_position;
pub mod vertex_commands;
