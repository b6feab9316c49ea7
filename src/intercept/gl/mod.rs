//! OpenGL and OpenGL ES, through GLX and EGL.
//!
//! The vendor wrappers ([`vendor_glx`], [`vendor_egl`]) give libglvnd our functions in place of
//! the driver's (`hook`). A [`context`] remembers what the program has set; its window's
//! framebuffer is ours ([`default_framebuffer`]), and each draw to it is issued once per view
//! ([`draw`]).

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
