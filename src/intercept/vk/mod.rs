//! Vulkan, as a layer between the loader and the driver.
//!
//! The loader asks [`negotiate`] for our two `Get…ProcAddr`. [`instance`] and [`device`] remember the next
//! layer's functions. A [`create`]'s images are ours: what stands between them and the window is a [`stand-in image`],
//! and [`present`] makes the outputs of it. With nothing to do the loader gets the next layer's own addresses.
//!
//! While a program draws to a swapchain's image, [`passes`] let it draw to an atlas, and [`draws`] issue each draw to
//! each tile. What is known of the program's objects is in [`images`], [`framebuffers`], [`pipelines`], [`layouts`],
//! [`descriptors`], [`pushed`] and [`memory`]; of its command buffers in [`recording`]. [`runs`] find its lens when they are
//! submitted, and [`parameters`] leave out what is not to be seen then; [`offscreen`] finds scenes that reach the window through images of the program's own, of which there are
//! [`view copies`] for its shaders. What [`queries`] count is told as the program means it. What cannot be followed is shown flat, on the panel, with the reason in the log.

pub mod commands;
pub mod descriptors;
pub mod layer;
pub mod offscreen;
pub mod pipelines;
pub mod queries;
pub mod spirv;
pub mod state;
pub mod submit;
pub mod swapchain;
