//! The passes of a frame: the types that a backend gets, and their evaluation in f64.
//!
//! A [`Plan`](output_pass::Plan) has a pass for each output. A pass has a source, which turns a
//! pixel into a direction (`source`, with `optics`, `table` and `facets`), rectangles of pixels
//! ([`geom::rectangle`](crate::geom::rectangle)) that share a shader, and pictures that are
//! multiplied in or added (`mask`, `black`). `view_images` is the layout of the views' images in
//! memory. `tolerance` limits the error of an evaluation in f32.
//!
//! Nothing here is built from a rig; `sources` and `plan` do that.

pub mod black;
pub mod facets;
pub mod mask;
pub mod optics;
pub mod output_pass;
pub mod source;
pub mod table;
pub mod tolerance;
pub mod view_images;
