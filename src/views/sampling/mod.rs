//! First step of the planner: the directions that outputs show.
//!
//! `output_map` turns a pixel of an output into a direction and tells how densely the pixels sample
//! around it. `samples` follows lines over a picture (sides, circles, boundary curves of the
//! screen) and gathers directions along them. `pixel_width` keeps single faulty pixels of a
//! calibration from deciding on the resolution. `cone` answers how a view's part lies to a
//! direction or to a small patch of directions.
//!
//! Nothing here knows views: the room depends on the rig, on the exact maps of `warp`, and on the
//! request.

pub mod cone;
pub mod output_map;
mod pixel_width;
pub mod samples;
