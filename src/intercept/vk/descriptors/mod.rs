//! TODO-NOTE

pub mod per_view_sets;
pub mod push_descriptors;
pub mod sets;
