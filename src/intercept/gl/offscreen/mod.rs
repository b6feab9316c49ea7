//! TODO-NOTE

pub mod blits;
pub mod coverage;
pub mod displayed;
pub mod draws;
pub mod report;
pub mod sampling;
pub mod scene_graph;
pub mod target;
pub mod view_copies;
