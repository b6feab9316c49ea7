//! TODO-NOTE

pub mod draw_groups;
pub mod host_memory;
pub mod queue;
