//! TODO-NOTE

pub mod begin_end;
pub mod display_lists;
pub mod matrices;
pub mod raster_position;
pub mod vertex_commands;
