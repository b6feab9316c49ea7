//! Entry of the program's calls into Cupola.
//!
//! libglvnd loads Cupola as a vendor ([`glx`], [`egl`]). Cupola loads the real vendor and answers
//! its names with hooks ([`table`]). [`contexts`] follows which context is current on a thread.
//! When a context becomes current with a window, [`attach`] makes the stand-in for the window,
//! resumes it, or takes it over from another context of the group. [`display_sync`]: what does the
//! rig ask of the driver for the swaps of a window?
//!
//! ```text
//! program → libglvnd → vendor → hook of Cupola (in another folder) → driver
//! ```

pub mod attach;
pub mod contexts;
pub mod display_sync;
pub mod egl;
pub mod glx;
pub mod table;
pub mod vendor;
