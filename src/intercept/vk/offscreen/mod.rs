//! TODO-NOTE

pub mod following;
pub mod images;
pub mod scene_graph;
pub mod scenes;
pub mod view_copies;
