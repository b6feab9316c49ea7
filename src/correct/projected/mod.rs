//! TODO-NOTE

pub mod division;
pub mod matrices;
pub mod projection;
pub mod y_down;

// The build script compiles `division.rs` with the same module beside it.
use crate::geom::division::rule;
