//! Descriptor sets: which buffers and images shaders read.
//!
//! Answers the calls that make, update, copy and push descriptors. The stored data answers two
//! questions. Which buffer holds a matrix? Does a set refer to an image of the scene? If it does,
//! [`per_view_sets`] makes one copy of the set per view, with that view's image instead. State:
//! `state::descriptors`, `state::recording::bindings`.

pub mod per_view_sets;
pub mod push_descriptors;
pub mod sets;
