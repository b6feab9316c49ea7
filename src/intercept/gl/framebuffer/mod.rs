//! What stands in for framebuffer 0.
//!
//! Answers framebuffer bindings, clears, draw and read buffers, blits ([`bindings`],
//! [`direct_state`], [`direct_state_ext`]), reads ([`read_back`]) and commands on textures that can be drawn into
//! ([`textures`]). Owns the target: [`default_framebuffer`] makes the atlas, replaces it where window
//! or rig change, and enlarges it for the panel and the program's own picture; [`replan`] plans anew
//! for the number of draws; [`unsampled_areas`] prevents drawing to parts that no output samples.
//!
//! ```text
//! framebuffer 0 of the program = one atlas: view │ view │ … │ panel │ program's own picture
//! ```

pub mod accumulation;
pub mod bindings;
pub mod default_framebuffer;
pub mod direct_state;
pub mod direct_state_ext;
pub mod first_read;
pub mod first_read_color;
pub mod first_read_depth;
pub mod own_framebuffer;
pub mod read_back;
pub mod replan;
pub mod textures;
pub mod unsampled_areas;
pub mod window_answers;
