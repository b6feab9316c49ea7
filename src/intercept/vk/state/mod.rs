//! What Cupola knows of a device: the data of each feature, below the code that works on it.
//!
//! [`device`] puts the parts together. A file here has types, look-ups, and methods that
//! keep its data valid. It does not call other rooms. The rooms above add the behaviour, as functions that take the
//! parts that they need. [`hooks`] defines hooks; [`entry_points`] is the one table of the next
//! layer's functions that they call.
//!
//! ```text
//! device ─ driver, entry_points, flatness
//!        ─ recording ─ bindings, draw_groups, view_constants, queries
//!        ─ images, view_target, scene_graph, framebuffers, swapchains
//!        ─ descriptors, set_contents, pipelines, host_memory
//!        ─ atlas_layout, own_image (vocabulary)
//! ```

pub mod atlas_layout;
pub mod bindings;
pub mod compute_bindings;
pub mod descriptors;
pub mod device;
pub mod division_counter;
pub mod draw_groups;
pub mod draw_parameters;
pub mod driver;
pub mod entry_points;
pub mod flatness;
pub mod formats;
pub mod framebuffers;
pub mod hooks;
pub mod host_memory;
pub mod images;
pub mod instance;
pub mod own_image;
pub mod pipelines;
pub mod queries;
pub mod recording;
pub mod scene_graph;
pub mod set_contents;
pub mod structures;
pub mod swapchains;
pub mod vertices;
pub mod view_constants;
pub mod view_target;
