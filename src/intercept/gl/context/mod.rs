//! A context of the program.
//!
//! [`gl_context::Context`] holds the state of all features and is passed to hooks ([`hooks`],
//! [`current`]). [`registry`] knows all contexts of the process. [`window_space`] sets viewport and
//! scissor of the driver, [`list_recording`] records display lists, [`list_names`] keeps their names
//! apart, [`own_calls`] is the scope of internal calls. [`errors`] separates the program's errors from those of Cupola, [`methods`]
//! tells the methods of the rig's outputs.

pub mod current;
pub mod errors;
pub mod gl_context;
pub mod hooks;
pub mod list_names;
pub mod list_recording;
pub mod methods;
pub mod own_calls;
pub mod read_pixels;
pub mod registry;
pub mod window_space;
