//! The text of the program's shaders: what it says, and what Cupola adds to it.
//!
//! [`prover`] proves from the text of a vertex shader that positions are an attribute times
//! matrices, [`dependence`] finds what flows into the position, and [`compute`] what a compute
//! shader reads and writes. [`patch`] adds the epilogue that re-projects `gl_Position`, and
//! [`frag_coord`] gives fragment shaders window coordinates of the program.

pub mod compute;
pub mod dependence;
mod elements;
pub mod frag_coord;
pub mod head;
pub mod patch;
pub mod prover;
