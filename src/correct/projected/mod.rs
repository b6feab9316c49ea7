//! Shader text and numbers for the methods `vertex` and `primitive`, which project the program's
//! vertices to the output.
//!
//! `projection` has the functions that are inserted into a program's vertex shader, `division` the
//! stages that cut primitives where straight edges would err. `matrices` gives both their numbers,
//! `y_down` turns these for Vulkan.

pub mod division;
pub mod matrices;
pub mod projection;
pub mod y_down;

// The build script compiles `division.rs` with the same module beside it.
use crate::geom::division::rule;
