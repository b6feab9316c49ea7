//! Vulkan, as a layer between the loader and the driver.
//!
//! # The modules, from top to bottom
//!
//! A file uses files of its own module and of the modules below.
//!
//! | module | purpose |
//! |---|---|
//! | `layer` | interface to the loader; life of instances and devices; table of hooks |
//! | `swapchain` | stand-in images for a window; correction and presentation |
//! | `submit` | classes of recorded draws; view constants; memory of the host |
//! | `queries` | counts of queries as the program expects them |
//! | `commands` | recording: passes, draws, clears, copies |
//! | `descriptors` | descriptor sets, and their copies for each view |
//! | `offscreen` | scenes that the program draws to images on their way to the window |
//! | `pipelines` | variants of pipelines for views and panel |
//! | `projected_vertices` | methods `vertex` and `primitive`: decision, geometry stage that divides |
//! | `state` | data about a device, one file per feature; macro and entry points of the hooks |
//! | `spirv` | shaders: matrices, reprojection |
//!
//! # One draw
//!
//! ```text
//! vkCmdBeginRenderPass   commands::passes        attachments → atlas and atlas copies
//! vkCmdDraw              commands::draws         hook
//!                        commands::draws::replicate  classify → select → issue
//!                        commands::draws::tiles      one draw per view, panel and primary view
//! vkQueueSubmit          submit::queue           hook
//!                        submit::draw_groups       matrices → lens → scene, flat or behind
//!                        state::views             reprojection matrix of each view → memory
//! ```
//!
//! A command buffer may be recorded long before its uniform blocks are filled, and may be submitted
//! many times. So draws are issued to all tiles that may show them. At submission, the matrices of
//! the shaders are chosen so that a draw lands outside each tile that must not show it.
//!
//! # One present
//!
//! ```text
//! vkQueuePresentKHR      swapchain::present      the rig's file is followed; scenes are chosen
//!                        swapchain::stand_in       atlas → outputs, by backend::vk
//!                        swapchain::read_back      captures, where they are asked for
//!                        next layer                the real image is presented
//! ```
//!
//! Draws that cannot be followed are shown flat on the panel, with the [`Obstacle`] in the log.
//!
//! [`Obstacle`]: crate::intercept::scene::obstacle::Obstacle

pub mod commands;
pub mod descriptors;
pub mod layer;
pub mod offscreen;
pub mod pipelines;
pub mod projected_vertices;
pub mod queries;
pub mod spirv;
pub mod state;
pub mod submit;
pub mod swapchain;
