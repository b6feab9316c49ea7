//! The data of each feature.
//!
//! A file for each feature: types, and methods that need nothing but these and the driver. No file
//! here names [`Context`](super::context::gl_context::Context). What a feature does with its state is
//! in the room of the feature, above.

pub mod attribute_stack;
pub mod background;
pub mod begin_end;
pub mod bounds;
pub mod buffer_bindings;
pub mod buffers;
pub mod cleared_views;
pub mod default_framebuffer;
pub mod division_counter;
pub mod draw;
pub mod draw_count;
pub mod fixed_function;
pub mod fixed_pipeline;
pub mod front_buffer;
pub mod max_width;
pub mod offscreen;
pub mod primitives;
pub mod profile;
pub mod program_pipelines;
pub mod programs;
pub mod projection;
pub mod queries;
pub mod raster_position;
pub mod statistics;
pub mod uniform_mirror;
pub mod uniforms;
pub mod variants;
pub mod vertex_arrays;
pub mod vertex_commands;
pub mod vertex_ranges;
pub mod vertex_recorder;
pub mod views;
pub mod window;
pub mod window_config;
pub mod window_space;
