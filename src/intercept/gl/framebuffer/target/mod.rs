//! The stand-in for the window's framebuffer, from its making to its end.
//!
//! [`make`] makes the atlas of a plan; [`attach`] puts it in the window's place, and makes another
//! where window or rig change. [`enlarge`] adds tiles for the panel and the program's own picture,
//! with what was drawn. [`replan`] plans anew for the number of draws of a frame.
//! [`unsampled_areas`] prevents drawing to parts that no output samples. The data is in
//! `state::drawable`.

pub mod attach;
pub mod enlarge;
pub mod make;
pub mod replan;
pub mod unsampled_areas;
