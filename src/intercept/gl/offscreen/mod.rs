//! Scenes that the program draws to textures.
//!
//! An image that lies between a scene and the window gets a copy with a tile per view
//! ([`view_copies`]). [`draws`] issues draws to the copies, [`displayed`] shows them in the
//! window's views, [`transfers`] copies between them. [`coverage`] finds out whether a draw fills
//! the window, [`scene_graph`] which images are needed, [`sampling`] which images a draw samples.
//! [`backdrop`] brings the background of a scene into all views. [`computed`] repeats dispatches of
//! compute shaders. [`inspected`] describes draws for `cupola inspect`. If the views are drawn in
//! turn, there are no copies, and [`in_turn`] has the draws.
//!
//! ```text
//! scene → image of the program (a tile per view) → … → flat draw that fills the window → each view
//! ```

pub mod backdrop;
pub mod computed;
pub mod coverage;
pub mod displayed;
pub mod draws;
pub mod framebuffer_statistics;
pub mod in_turn;
pub mod inspected;
pub mod sampling;
pub mod scene_graph;
pub mod target;
pub mod transfers;
pub mod view_copies;
