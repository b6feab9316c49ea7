//! Commands of the program on framebuffers, and on textures that the program can draw to.
//!
//! A stand-in image replaces the program's framebuffer 0 ([`bindings`]), its front and back buffer
//! are one image ([`draw_buffers`]). [`clears`], [`blits`] and [`accumulation`] go to all views, or
//! to the program's own pictures in the atlas. [`direct_state`] and [`direct_state_ext`] are the
//! same commands with the framebuffer's name instead of a binding. [`window_answers`] answers
//! questions about the window. [`textures`] notes changes of images.

pub mod accumulation;
pub mod bindings;
pub mod blits;
pub mod clears;
pub mod direct_state;
pub mod direct_state_ext;
pub mod draw_buffers;
pub mod summed_pixels;
pub mod textures;
pub mod window_answers;
