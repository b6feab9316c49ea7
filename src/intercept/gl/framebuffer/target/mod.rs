//! The stand-in for the window's framebuffer, from its creation to its end.
//!
//! [`make`] makes the atlas of a plan. [`attach`] replaces the window's framebuffer by it, and
//! makes another one if window or rig change. [`enlarge`] adds tiles for the panel and the
//! program's own picture, and keeps earlier drawing. [`replan`] plans again for the number of draws
//! of a frame. [`rough`] shows a rig that is being edited. [`unsampled_areas`] prevents drawing to
//! parts that no output samples. The data is in `state::drawable`.

pub mod attach;
pub mod enlarge;
pub mod make;
pub mod replan;
pub mod rough;
pub mod unsampled_areas;
