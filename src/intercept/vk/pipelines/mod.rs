//! Pipelines: `vkCreateGraphicsPipelines`, shader modules and pipeline layouts.
//!
//! Each pipeline of the program gets two variants. One draws into a view, with the reprojection
//! inserted into its last stage before rasterisation. The other draws onto the panel, whose alpha
//! channel records where the panel is covered. If the shaders write to buffers or images, there are
//! two more, without these writes (`spirv::without_writes`), so that a draw writes once.
//! `matrix_sources` reads the value of a matrix that `spirv::reflect` found. Each pipeline layout
//! gets one more descriptor set, for the view constants. State: `state::pipelines`.
//!
//! ```text
//! state::pipelines::create_info ─ variants ─┬─ spirv::splice, without_writes
//!                                           ├─ view_stages ─ spirv::frag_coord, texels, camera_matrices
//!                                           ├─ projected_vertices::dividing_stage
//!                                           └─ create
//! ```

pub mod compute;
pub mod create;
pub mod layouts;
pub mod matrix_sources;
pub mod program_pipelines;
pub mod variants;
pub mod view_stages;
