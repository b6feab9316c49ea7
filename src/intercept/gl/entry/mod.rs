//! Entry of the program's calls into Cupola.
//!
//! libglvnd loads Cupola as a vendor ([`glx`], [`egl`]). Cupola loads the real vendor and answers
//! its names with hooks ([`table`]). [`contexts`] follows which context is current on a thread.
//! When a context becomes current with a window, [`attach`] makes the stand-in for the window,
//! resumes it, or takes it over from another context of the group.
//!
//! ```text
//! program → libglvnd → vendor → hook of Cupola (in another folder) → driver
//! ```

pub mod attach;
pub mod contexts;
pub mod egl;
pub mod glx;
pub mod table;
pub mod vendor;
