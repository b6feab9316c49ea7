//! How the program's calls reach us.
//!
//! libglvnd loads us as a vendor ([`glx`], [`egl`]); we load the real one and answer its names with
//! our hooks ([`table`]). [`contexts`] is the table of all contexts of the process by their
//! handles, [`attach`] is what happens when one becomes current with a window: its target is made,
//! resumed, or taken over from another context of the group.
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
