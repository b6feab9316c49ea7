//! Descriptor sets: which buffers and images shaders read.
//!
//! Answers the calls that make, update, copy and push descriptors. Two questions are answered from
//! what is kept: in which buffer is a matrix, and does a set show an image of the scene? Of a set
//! that does, [`per_view_sets`] makes one copy per view, with that view's image in its place.
//! State: `state::descriptors`, `state::recording::bindings`.

pub mod per_view_sets;
pub mod push_descriptors;
pub mod sets;
