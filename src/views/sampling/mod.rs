//! First step of the planner: the directions that outputs show.
//!
//! `output_map` turns a pixel of an output into a direction, and finds how densely the pixels
//! sample around it (`sample`); `projector_map` is its part for projectors, `boundary` finds the
//! curves at which its content ends. `samples` follows lines over a picture (sides, circles,
//! boundary curves of the screen) and gathers directions along them. `pixel_width` prevents single
//! faulty pixels of a calibration from deciding on the resolution. `cone` tests the position of a
//! direction, or of a small patch of directions, relative to a view's part.
//!
//! Except for `cone`, nothing here uses views. The folder depends on the rig, on the exact maps of
//! `warp`, and on the request.

mod boundary;
pub mod cone;
pub mod effort;
pub mod output_map;
mod pixel_width;
mod projector_map;
pub mod sample;
pub mod samples;
