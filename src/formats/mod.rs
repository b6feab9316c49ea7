//! Calibration files of other tools, read and written.
//!
//! A reader takes bytes and the file's name. It returns the file's content, or an error with the
//! file, the line or offset, the reason and the expected value. Files come from anywhere: sizes in
//! headers are compared with the file's length before anything is allocated, archives are unpacked
//! within limits, and numbers that are not finite are refused. Where other programs read a format
//! differently, Cupola accepts each variant that it can recognise; `notes` name its assumptions.
//!
//! A calibration takes this way: the format's module makes a [`Grid`] of it (nodes with triangles,
//! or a value for each pixel); a rig's output gives the grid's values their meaning (a position in
//! a picture, a point, a direction). At run time only [`bourke`], [`pfm`](pictures::pfm), [`obj`]
//! and [`levels`](pictures::levels) are read. `cupola convert` turns all other formats into these,
//! so that the injected library contains no reader for archives or XML.

mod camera;
mod grid;
mod reading;

pub mod bourke;
pub mod domeprojection;
pub mod easyblend;
pub mod mpcdi;
pub mod obj;
pub mod pictures;
pub mod sgct;
pub mod vwf;

pub use camera::Camera;
pub use grid::{Grid, MOST_NODES, Mesh, Node, Raster, Sample};
pub use pictures::levels::Levels;
pub use reading::input::{LONGEST_FILE, MOST_PIXELS, MOST_PIXELS_TOGETHER, Noted, png_luma, read_at_most, read_file};
