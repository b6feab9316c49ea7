//! The data of each feature.
//!
//! A folder for each part of a context, with the part's struct in its `mod.rs`: types, and methods
//! that need nothing but these and the driver. No file here names
//! [`Context`](super::context::gl_context::Context). What a feature does with its state is in the
//! room of the feature, above.

pub mod app;
pub mod compat;
pub mod draw;
pub mod drawable;
pub mod driver;
pub mod frame;
pub mod offscreen;
pub mod projected_vertices;
pub mod queries;
pub mod shader;
pub mod vertex_input;
