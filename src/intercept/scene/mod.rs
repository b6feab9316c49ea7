//! Decisions about a program's frame that are the same for both APIs. Neither of them is named
//! here.
//!
//! - [`viewport`]: does a viewport hold the program's main picture?
//! - [`eye`]: does a shader hold the projection and the view matrix apart?
//! - [`frame_order`]: does flat drawing lie behind the scene?
//! - [`image_graph`]: which images lie between a scene and the window?
//! - [`flat_program`]: is nothing of the program a scene?
//! - [`culling_program`]: does it leave out what it does not see itself?
//! - [`obstacle`]: why is something shown flat, or drawn once only?
//! - [`query_scaling`]: what does a query's count become for the program?
//! - [`common_statistics`]: what do the statistics say of a plan?
//! - [`to_window`]: where is a fragment of a view in the program's window?
//!
//! ```text
//! draw ─ main viewport? ─ lens known? ─ yes → scene, once per view
//!              │               │
//!              no              no
//!              ▼               ▼
//!            flat ◄──── flat; behind, if the last frame drew flat things before its scene
//! ```
//!
//! The rooms of OpenGL and Vulkan collect the facts and issue the draws.

pub mod common_statistics;
pub mod culling_program;
pub mod eye;
pub mod flat_program;
pub mod frame_order;
pub mod image_graph;
pub mod obstacle;
pub mod query_scaling;
pub mod to_window;
pub mod viewport;
