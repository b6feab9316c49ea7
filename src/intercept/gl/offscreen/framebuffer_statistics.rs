//! Statistics of the program's framebuffers.

use crate::intercept::gl::offscreen::view_copies::{duplicate_mode, possible};
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::offscreen::framebuffers::Framebuffer;
use crate::intercept::gl::state::offscreen::images::Image;
use crate::intercept::scene::flat_program::OffScreen;
use crate::intercept::scene::obstacle::{Obstacle, SHOWN_SMALL};
use crate::rig::Duplicate;
use std::collections::BTreeMap;

/// Returns the number of `framebuffers` that are drawn once per view, and the numbers of the others
/// for each reason. `images`: the images of the context's group.
pub fn status(drawable: &Drawable, images: &[Image], framebuffers: &[Framebuffer]) -> (u64, BTreeMap<String, u64>) {
    let mut single: BTreeMap<String, u64> = BTreeMap::new();
    let mut duplicated = 0;
    for framebuffer in framebuffers {
        match obstacle(drawable, images, framebuffer) {
            None => duplicated += 1,
            Some(obstacle) => {
                if let Some(reason) = obstacle.reason() {
                    *single.entry(reason.to_owned()).or_default() += 1;
                }
            }
        }
    }
    (duplicated, single)
}

/// Returns how the program draws to `framebuffers`.
pub fn off_screen(drawable: &Drawable, images: &[Image], framebuffers: &[Framebuffer]) -> OffScreen {
    let is_scene = |image: &Image| image.scene || image.other_shape && image.shown_small;
    let holds_scene = |framebuffer: &&Framebuffer| any_colour(images, framebuffer, is_scene);
    match framebuffers.iter().find(holds_scene) {
        Some(framebuffer) => OffScreen::Scene(reason(drawable, images, framebuffer)),
        None if framebuffers.is_empty() => OffScreen::Nothing,
        None => OffScreen::Flat,
    }
}

/// Returns the reason why a framebuffer is drawn once only; `None` if it is drawn once per view.
pub fn reason(drawable: &Drawable, images: &[Image], framebuffer: &Framebuffer) -> Option<String> {
    let obstacle = obstacle(drawable, images, framebuffer)?;
    Some(obstacle.reason().unwrap_or("everything is shown flat").to_owned())
}

/// Returns the reason why a framebuffer is drawn once only; `None` if it is drawn once per view.
fn obstacle(drawable: &Drawable, images: &[Image], framebuffer: &Framebuffer) -> Option<Obstacle> {
    if framebuffer.has_view_copies(images) {
        return None;
    }
    let any = |test: fn(&Image) -> bool| any_colour(images, framebuffer, test);
    if let Some(obstacle) = &framebuffer.obstacle {
        return Some(obstacle.clone());
    }
    let reason = if duplicate_mode() == Duplicate::Never {
        "duplicate is \"never\""
    } else if !possible(drawable) {
        "the rig shows the program's own picture"
    } else if framebuffer.colours().next().is_none() {
        "it has no colours, as a shadow map"
    } else if any(|image| image.refused) {
        "the driver cannot make copies of it"
    } else if any(|image| image.lost) {
        "it is read or written by compute shaders that cannot be followed"
    } else if any(|image| image.shown_small && !image.displayed && (image.scene || image.other_shape)) {
        SHOWN_SMALL
    } else if any(|image| image.other_shape && !image.scene) {
        "its picture has another shape than the window, as a shadow map or a mirror"
    } else if !any(|image| image.scene || !image.reads.is_empty()) {
        "nothing in perspective is drawn into it"
    } else {
        "it was not seen to fill the window"
    };
    Some(reason.into())
}

/// True if any of a framebuffer's colour images has this property.
fn any_colour(images: &[Image], framebuffer: &Framebuffer, test: impl Fn(&Image) -> bool) -> bool {
    framebuffer.colours().filter_map(|name| images.iter().find(|image| image.name == name)).any(test)
}
