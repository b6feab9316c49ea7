//! Entry of the program's calls.
//!
//! libglvnd loads us as a vendor ([`glx`], [`egl`]); we load the real one and answer its names with
//! our hooks ([`table`]). [`contexts`] follows which context is current on a thread. When one
//! becomes current with a window, [`attach`] makes its target, resumes it, or takes it over from
//! another context of the group.
//!
//! ```text
//! program → libglvnd → vendor → our hook (a room below) → driver
//! ```

pub mod attach;
pub mod contexts;
pub mod egl;
pub mod glx;
pub mod table;
pub mod vendor;
