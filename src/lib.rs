//! Cupola puts existing OpenGL and Vulkan programs on domes.
//!
//! Data flow: a [`rig`] describes dome, viewer and outputs. [`views`] computes the directions that
//! the outputs sample, and the fewest, tightest perspective views that show them, packed into one
//! atlas. The program is drawn into those views (by [`intercept`], or by itself through
//! [`ffi`] or [`runtime::embedded`]). [`correct`] turns rig and views into passes, which a
//! [`backend`] runs: each output pixel is traced to the dome and to the viewer ([`warp`] does so
//! exactly), sampled once, weighted ([`blend`]) and presented.
//!
//! Most programs need only the command `cupola`, and no code. To use the library:
//!
//! ```
//! use cupola::{rig, views};
//!
//! let rig = rig::load("fisheye")?; // a preset or a file
//! let request = views::Request {
//!     output_sizes: vec![(2048, 2048)],
//!     window: (2048, 2048),
//!     panel: false,
//!     primary: false,
//!     max_atlas: 16384,
//! };
//! let plan = views::plan(&rig, &request)?;
//! assert!(plan.views.len() <= 5);
//! println!("{}", views::report(&plan, &rig, &request.output_sizes));
//! # Ok::<(), cupola::Error>(())
//! ```
//!
//! - [`runtime::embedded`]: a program draws its views itself and has them corrected.
//! - [`warp::WarpMap`]: the direction that a pixel shows, in f64, without a graphics card.
//! - [`blend`]: the sum of the light of all projectors on the dome.
//! - [`calibrate`]: the real positions of projectors, from marks or photographs.
//!
//! Units and conventions, everywhere: metres and degrees in files, radians in code; right-handed
//! axes, x right, y up, −z forward; column vectors; f64 on the CPU, f32 only in
//! [`correct`]; pixel centres at +½; image row 0 at the top; atlas tiles count from
//! the bottom left, as OpenGL windows do.

pub mod backend;
pub mod blend;
pub mod cache;
pub mod calibrate;
pub mod correct;
pub mod digest;
pub mod error;
pub mod fence;
pub mod ffi;
pub mod formats;
pub mod geom;
pub mod intercept;
pub mod lock;
pub mod message;
pub mod nodes;
pub mod rig;
pub mod ring;
pub mod runtime;
pub mod system;
#[cfg(test)]
mod testing;
pub mod views;
pub mod warp;

pub use error::{Error, ErrorKind, Result};
pub use ffi::CUPOLA_ABI_VERSION as ABI_VERSION;
