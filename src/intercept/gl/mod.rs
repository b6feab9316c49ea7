//! OpenGL and OpenGL ES, through GLX and EGL.
//!
//! The window's framebuffer 0 is an atlas of the rig's views, and each draw of the scene is issued
//! once per view.
//!
//! # One draw
//!
//! ```text
//! glDrawElements      draw::arrays            hook; finds the vertices if that is needed
//!   dispatch          draw::routing           to the window, or to a framebuffer of the program?
//!   classify          per_view::classify      scene, background or flat, by matrix and viewport
//!   select            per_view::culling       views that can show the draw
//!   issue             per_view::issue         per view: window space, projection, driver's call
//!     projection      shader, state::compat, projected_vertices
//!     factors         queries::scaling        factors for the program's queries
//! ```
//!
//! # One swap
//!
//! ```text
//! glXSwapBuffers      entry::glx              the driver's function is called in between
//!   before            frame::present          resolve, correct the views into the window, capture
//!   after             frame::present          end of the frame in offscreen, cameras, buffers
//!     size, rig       framebuffer             new plan if the window or the rig changed
//! ```
//!
//! # Folders
//!
//! The folders in their order: `entry`, `frame`, `compat`, `app_state`, `draw`, `framebuffer`,
//! `offscreen`, `per_view`, `projected_vertices`, `shader`, `queries`, `vertex_input`, `context`,
//! `state`. A folder uses only folders that come after it in this list. `state` holds the data of
//! each feature. [`context::gl_context::Context`] puts these data together. The code of each
//! feature is in the feature's own folder.

pub mod app_state;
pub mod compat;
pub mod context;
pub mod draw;
pub mod entry;
pub mod frame;
pub mod framebuffer;
pub mod offscreen;
pub mod per_view;
pub mod projected_vertices;
pub mod queries;
pub mod shader;
pub mod state;
pub mod vertex_input;
