//! One draw of the program as one draw per view.
//!
//! ```text
//! classify → culling::select → issue(target)
//! ```
//!
//! [`classify`] separates scenes from flat drawing, [`culling`] leaves out views that cannot show a
//! draw, [`issue`] is the loop over the views. Its target is passed in: the atlas of the window
//! (`draw::routing`) or the per-view copies of a framebuffer (`offscreen::target`).
//! [`window_space`] moves the program's viewport and scissor to a tile. [`panel`] has the blending
//! and the clears of the flat panel, [`background`] the flat drawing behind the scene, [`backdrop`]
//! such drawing that fills the picture.
//! [`wide_primitives`] cuts points and lines at the border of their tile.

pub mod backdrop;
pub mod background;
pub mod classify;
pub mod culling;
pub mod issue;
pub mod panel;
pub mod wide_primitives;
pub mod window_space;
