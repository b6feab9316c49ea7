//! Swapchains: `vkCreateSwapchainKHR`, `vkGetSwapchainImagesKHR`, `vkDestroySwapchainKHR` and
//! `vkQueuePresentKHR`.
//!
//! The program gets stand-in images in place of a swapchain's own; each has an atlas for the views
//! and the panel. When it presents one, the correction draws the real image from the atlas, or from
//! the stand-in image on the panel if nothing was drawn to views. State: `state::swapchains`, which
//! this room alone changes.
//!
//! ```text
//! program ─ draws flat ──► stand-in image ─ copied to the panel ─┐
//!         └ draws views ─► atlas ────────────────────────────────┴─ correction ─► real image
//! ```

pub mod create;
mod images;
pub mod present;
pub mod publish;
pub mod read_back;
mod record;
pub mod stand_in;
