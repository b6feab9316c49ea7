//! Scenes that the program draws to images of its own on their way to the window.
//!
//! While commands are recorded, [`scene_graph`] notes what is drawn to an image and what is made
//! from it. Between two frames it chooses the images that lie between a scene and the window. From
//! then on such an image is drawn once per view, to an atlas of its own. From the atlas,
//! [`view_copies`] makes one image per view for the program's shaders. Answers `vkCreateImage`,
//! `vkCreateImageView` and their counterparts. State: `state::images`.
//!
//! ```text
//! scene ─ draws ─► atlas of the image ─ view copies ─ sampled by each view's draw ─► window's atlas
//! ```

pub mod coverage;
pub mod following;
pub mod images;
pub mod scene_graph;
pub mod scenes;
pub mod view_copies;
pub mod view_images;
