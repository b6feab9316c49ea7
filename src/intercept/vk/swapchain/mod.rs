//! Swapchains: `vkCreateSwapchainKHR`, `vkGetSwapchainImagesKHR`, `vkDestroySwapchainKHR` and
//! `vkQueuePresentKHR`. [`surfaces`] gives windows the size of `--size`.
//!
//! The program gets stand-in images in place of the images of a swapchain. Each has an atlas for
//! the views and the panel. When the program presents one, the correction draws the real image from
//! the atlas. If nothing was drawn to views, it draws the stand-in image on the panel. State:
//! `state::swapchains`, which only this module changes.
//!
//! ```text
//! program ─ draws flat ──► stand-in image ─ copied to the panel ─┐
//!         └ draws views ─► atlas ────────────────────────────────┴─ correction ─► real image
//! ```

pub mod create;
mod follow;
mod images;
pub mod present;
pub mod publish;
pub mod read_back;
mod record;
pub mod stand_in;
pub mod surfaces;
mod swaps;
