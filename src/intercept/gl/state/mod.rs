//! The data of each feature.
//!
//! Each part of a context has a folder or a file, with the struct of the part. The files contain
//! types, and methods that need only these types and the driver. No file here names
//! [`Context`](super::context::gl_context::Context). The code that uses the state of a feature is
//! in the feature's folder in `gl`.

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
