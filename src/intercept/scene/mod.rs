//! Decisions about a program's frame that are the same for both APIs. No API is named here.
//!
//! - [`viewport`]: does a viewport hold the program's main picture?
//! - [`lens`]: which of a program's matrices holds its lens?
//! - [`camera`]: with which lenses does the program draw, and what is each view's transform?
//! - [`eye`]: does a shader keep the projection and the view matrix separate?
//! - [`frame_order`]: does flat drawing lie behind the scene?
//! - [`image_graph`]: which images lie between a scene and the window?
//! - [`flat_program`]: does the program draw no scene at all?
//! - [`culling_program`]: does the program leave out objects outside its own picture?
//! - [`obstacle`]: why is something shown flat, or drawn only once?
//! - [`query_scaling`]: which count does the program get for a query?
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
//! The modules of OpenGL and Vulkan collect the facts and issue the draws.

pub mod camera;
pub mod culling_program;
pub mod eye;
pub mod flat_program;
pub mod frame_order;
pub mod image_graph;
pub mod lens;
pub mod obstacle;
pub mod query_scaling;
pub mod to_window;
pub mod viewport;
