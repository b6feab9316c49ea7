//! Cupola puts existing OpenGL programs on domes.
//!
//! Data flow: a [`rig`] says what stands where. [`views`] computes which directions the rig's
//! outputs sample and the fewest, tightest perspective views that show them, packed into one
//! atlas. The program is drawn into those views (by [`intercept`], or by itself through
//! [`ffi`]). [`correct`] turns rig and views into passes, which a [`backend`] runs: each output
//! pixel is traced to the dome and to the viewer ([`warp`]), sampled once, weighted ([`blend`])
//! and presented.
//!
//! Units and conventions, everywhere: metres and degrees in files, radians in code; right-handed
//! axes, x right, y up, −z forward; column vectors; f64 on the CPU, f32 only in
//! [`correct::uniforms`]; pixel centres at +½; image row 0 at the top; atlas tiles count from
//! the bottom left, as OpenGL windows do.

pub mod backend;
pub mod blend;
pub mod correct;
pub mod error;
pub mod fence;
pub mod ffi;
pub mod geom;
pub mod intercept;
pub mod rig;
pub mod runtime;
pub mod views;
pub mod warp;

pub use error::{Error, ErrorKind, Result};
