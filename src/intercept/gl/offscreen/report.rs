//! What the statistics say of the program's framebuffers.
//!
//! What is known of images is in the context of a group that was current last; so that context is asked for the framebuffers
//! of others.

use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::offscreen::view_copies::{duplicate_mode, possible};
use crate::intercept::gl::state::offscreen::framebuffers::Framebuffer;
use crate::intercept::gl::state::offscreen::images::Image;
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;
use crate::intercept::scene::flat_program::OffScreen;
use crate::intercept::scene::obstacle::Obstacle;
use crate::rig::Duplicate;
use std::collections::BTreeMap;

/// How many `framebuffers` that the program drew to are drawn once per view, and why how many others are not.
pub fn status(ctx: &Context, framebuffers: &[Framebuffer]) -> (u64, BTreeMap<String, u64>) {
    let mut single: BTreeMap<String, u64> = BTreeMap::new();
    let mut duplicated = 0;
    for framebuffer in framebuffers {
        match obstacle(ctx, framebuffer) {
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

/// What the program draws to `framebuffers`.
pub fn off_screen(ctx: &Context, framebuffers: &[Framebuffer]) -> OffScreen {
    let holds_scene = |framebuffer: &&Framebuffer| {
        framebuffer.colours().filter_map(|name| ctx.view_copies.image(name)).any(|image| image.scene)
    };
    match framebuffers.iter().find(holds_scene) {
        Some(framebuffer) => OffScreen::Scene(reason(ctx, framebuffer)),
        None if framebuffers.is_empty() => OffScreen::Nothing,
        None => OffScreen::Flat,
    }
}

/// How many draws to the program's framebuffers were issued once per view.
pub fn draws(view_copies: &ViewCopies) -> u64 {
    view_copies.issued.draws
}

/// For each view, without end: how many of them it got, and how many were left out of it.
pub fn counts(ctx: &Context) -> impl Iterator<Item = [u64; 2]> + '_ {
    (0..).map(|index| ctx.view_copies.issued.of_view(index))
}

/// Why a framebuffer is drawn once only; `None`: it is drawn once per view.
pub fn reason(ctx: &Context, framebuffer: &Framebuffer) -> Option<String> {
    let obstacle = obstacle(ctx, framebuffer)?;
    Some(obstacle.reason().unwrap_or("everything is shown flat").to_owned())
}

/// Why a framebuffer is drawn once only.
fn obstacle(ctx: &Context, framebuffer: &Framebuffer) -> Option<Obstacle> {
    if ctx.view_copies.has_view_copies(framebuffer) {
        return None;
    }
    let any = |test: fn(&Image) -> bool| framebuffer.colours().filter_map(|name| ctx.view_copies.image(name)).any(test);
    if let Some(obstacle) = &framebuffer.obstacle {
        return Some(obstacle.clone());
    }
    let reason = if duplicate_mode() == Duplicate::Never {
        "duplicate is \"never\""
    } else if !possible(ctx) {
        "the rig shows the program's own picture"
    } else if framebuffer.colours().next().is_none() {
        "it has no colours, as a shadow map"
    } else if any(|image| image.refused) {
        "the driver gives no copies of it"
    } else if any(|image| image.other_shape && !image.scene) {
        "its picture has another shape than the window, as a shadow map or a mirror"
    } else if !any(|image| image.scene || !image.reads.is_empty()) {
        "nothing in perspective is drawn into it"
    } else {
        "it was not seen to fill the window"
    };
    Some(reason.into())
}
