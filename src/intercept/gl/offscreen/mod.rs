//! TODO-NOTE

pub mod copies;
pub mod coverage;
pub mod displayed;
pub mod draws;
pub mod report;
pub mod sampling;
pub mod scene_graph;
pub mod target;
pub mod view_copies;
