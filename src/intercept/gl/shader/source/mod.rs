//! Text of the program's shaders: analysis, and Cupola's additions.
//!
//! [`prover`] proves from the text of a vertex shader that positions are an attribute times
//! matrices. [`dependence`] finds the names that flow into the position, [`compute`] the images and
//! buffers that a compute shader reads and writes. [`patch`] adds the epilogue that re-projects
//! `gl_Position`. [`frag_coord`] gives fragment shaders window coordinates of the program. `text`
//! splits texts into words.

pub mod compute;
pub mod dependence;
mod elements;
pub mod frag_coord;
pub mod head;
pub mod patch;
pub mod prover;
pub(in crate::intercept::gl::shader) mod text;
