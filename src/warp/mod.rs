//! Exact maps from output pixels to directions, and the error of any other map against them.
//!
//! [`WarpMap`] traces each pixel ray by ray in f64, as a rig describes it. It uses neither the
//! closed form of the shaders nor their polynomials: it is the reference for them ([`accuracy`]).

pub mod accuracy;
mod exact;
#[cfg(test)]
pub(crate) mod testing;
mod traced;

pub use accuracy::{MapError, PixelError, compare, compare_each, displacement};
pub use exact::{WarpMap, camera_direction, exact_direction, exact_map};
pub use traced::TracedMap;
