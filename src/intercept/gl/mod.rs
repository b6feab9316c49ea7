//! OpenGL and OpenGL ES, through GLX and EGL.
//!
//! The vendor wrappers ([`vendor_glx`], [`vendor_egl`]) give libglvnd our functions in place of
//! the driver's (`hook`). A [`context`] remembers what the program believes; its window's
//! framebuffer is ours ([`default_framebuffer`]), and each draw to it is issued once per view
//! ([`draw`]).

pub mod accumulation;
pub mod background;
pub mod bound;
pub mod buffers;
pub mod conditional;
pub mod config;
pub mod context;
pub mod counting;
pub mod counts;
pub mod culling;
pub mod default_framebuffer;
pub mod draw;
pub mod duplicate;
pub mod errors;
pub mod feedback;
pub mod filtering;
mod first_color;
mod first_depth;
pub mod frames;
pub mod front;
pub mod glsl;
pub mod hidden;
mod hook;
pub mod immediate;
pub mod indexed;
pub mod known_state;
pub mod lists;
pub mod matrices;
pub mod named;
pub mod offscreen;
pub mod outlines;
pub mod pipelines;
pub mod present;
pub mod programs;
pub mod queries;
pub mod quiet;
pub mod raster;
pub mod reads;
pub mod reflection;
pub mod registry;
pub mod samplers;
pub mod state;
pub mod targets;
pub mod uniforms;
pub mod vendor;
pub mod vendor_egl;
pub mod vendor_glx;
pub mod vertex_arrays;
pub mod vertices;
pub mod window;
pub mod workload;
