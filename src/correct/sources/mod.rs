//! From an output of a rig to the coefficients of its map.
//!
//! `output_source` takes the closed form where there is one that f32 evaluates exactly enough:
//! `rounding` estimates the error, `ray_form` finds the cheapest evaluation for projectors.
//! Otherwise the output gets a table (`table`, `table_coarse`) or triangles (`facets`) of exact
//! samples, which `surface_sample` traces in f64. `table_cached` keeps tables for the next start.

pub mod facets;
pub mod output_source;
pub mod ray_form;
pub mod rounding;
pub mod surface_sample;
pub mod table;
pub mod table_cached;
pub mod table_coarse;
