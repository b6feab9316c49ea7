//! TODO-NOTE

pub mod cached;
pub mod cells;
pub mod choose;
pub mod cost;
pub mod dedicated;
pub mod partition;
pub mod planned_view;
pub mod projected;
