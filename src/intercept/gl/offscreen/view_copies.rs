//! Scenes that a program draws off screen and then shows. Each view gets its own picture.
//!
//! The `images` of the program's framebuffers record draws, sampled images and copies. From the
//! next frame on, each image that lies between a scene and the window (`scene_graph`) has a *view
//! copy* with a tile for each view. Framebuffers of Cupola with view copies replace the program's
//! (`framebuffers`), so draws of the scene need no change of the framebuffer. A tile has the size
//! of the program's own image, so sizes, texels and viewports that the program has set remain
//! valid. Before a flat draw that samples such an image (`sampling`) goes to a view, the view's
//! tile is copied to the program's own image. So filters, wrapping and sampler objects work without
//! being followed.
//!
//! `draws` issues draws to the view copies, except to those of views that cannot show them.
//! `displayed` brings the pictures into the window's views. `transfers` does the same for
//! `glBlitFramebuffer` and similar commands. `coverage` distinguishes the whole picture from a map
//! in its corner.

mod program_framebuffers;
mod program_images;

pub use program_framebuffers::clear_with;
pub(super) use program_framebuffers::{enter, look, look_at_read, make_framebuffer};
pub(super) use program_images::before_reading_images;
pub use program_images::{
    before_reading_framebuffer, before_reading_texture, forget_renderbuffer, forget_texture, is_alike, mipmaps,
    uploaded,
};

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::context::errors::{drop_errors, take_own_errors};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::offscreen::scene_graph;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::offscreen::images::{Image, Pair, Set};
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;
use crate::intercept::process::{log, settings};
use crate::lock::Lock;
use crate::rig::Duplicate;
use crate::runtime::Session;

/// Returns the user's setting of `duplicate`; `Never` if there are no settings.
pub(super) fn duplicate_mode() -> Duplicate {
    settings::settings().map_or(Duplicate::Never, |settings| settings.rig.views.duplicate)
}

/// True if images can have copies: some views have other lenses than the program's, and views are
/// not drawn in turn.
pub(super) fn possible(drawable: &Drawable) -> bool {
    let has_other_lenses = |s: &Session| s.turns().is_none() && s.views().iter().any(|v| !v.program_lens);
    duplicate_mode() != Duplicate::Never && drawable.session().is_some_and(has_other_lenses)
}

/// Returns the number of views.
pub(super) fn views(drawable: &Drawable) -> usize {
    drawable.session().map_or(0, |session| session.views().len())
}

/// Takes over the data that the group shares, when the context becomes current. It gives them back
/// when it is current no longer.
pub fn collect(ctx: &mut Context) {
    let taken = ctx.share.off_screen.locked().take();
    let Some(taken) = taken else { return };
    if !ctx.view_copies.images.is_empty() {
        // These data come from a time in which a context of another thread had the group's data.
        clear(ctx);
    }
    ctx.view_copies.shared = true;
    let own = &mut ctx.view_copies;
    let stale = own.deleted != taken.deleted;
    (own.images, own.learnt, own.own_picture) = (taken.images, taken.learnt, taken.own_picture);
    (own.deleted, own.issued) = (taken.deleted, taken.issued);
    own.parts = taken.parts;
    own.left.extend(taken.left);
    let (gl, id) = (ctx.driver.gl, ctx.driver.id);
    ctx.view_copies.left.retain(|pair| {
        if pair.context == id {
            pair.destroy(gl);
        }
        pair.context != id
    });
    // A context that draws to no window ends no frames.
    take_measurements(ctx);
    if stale {
        leave(ctx);
        ctx.view_copies.coverage.clear(gl);
        for framebuffer in &mut ctx.view_copies.framebuffers {
            framebuffer.known = false;
            framebuffer.destroy_view_copy(gl);
        }
    }
}

/// Deletes the view copy of an image.
fn destroy_view_copy(image: &mut Image, gl: &Gl, context: u64, left: &mut Vec<Pair>, deleted: &mut u64) {
    *deleted += u64::from(image.view_copy.is_some());
    left.extend(image.destroy_view_copy(gl, context));
}

/// Returns the number of tiles of a view copy.
pub(super) fn copy_count(drawable: &Drawable, view_copies: &ViewCopies) -> usize {
    views(drawable) + usize::from(view_copies.own_picture)
}

/// Returns the tile of the program's own picture. If there is none, returns the tile of the view
/// ahead.
pub(super) fn own_tile(drawable: &Drawable, view_copies: &ViewCopies) -> usize {
    let ahead = || drawable.session().map_or(0, |session| session.ahead());
    if view_copies.own_picture { views(drawable) } else { ahead() }
}

/// Binds the program's own draw framebuffer again, for calls that use its binding.
pub fn leave(ctx: &mut Context) {
    if std::mem::take(&mut ctx.view_copies.bound) {
        // SAFETY: what the program bound.
        unsafe {
            ctx.driver
                .gl
                .bind_framebuffer(crate::backend::gl::driver::api::GL_DRAW_FRAMEBUFFER, ctx.app.draw_framebuffer())
        };
        ctx.restore_window_space();
    }
}

/// Notes that the program has changed the binding, so that no framebuffer of Cupola is bound.
/// Returns true if one was bound.
pub fn rebound(view_copies: &mut ViewCopies) -> bool {
    std::mem::take(&mut view_copies.bound)
}

/// Notes a change of a framebuffer's attachments or draw buffers, which are examined again later.
pub fn forget(ctx: &mut Context, name: u32) {
    let Some(index) = ctx.view_copies.position(name) else { return };
    if ctx.app.draw_framebuffer() == name {
        leave(ctx);
    }
    let framebuffer = &mut ctx.view_copies.framebuffers[index];
    framebuffer.known = false;
    framebuffer.destroy_view_copy(ctx.driver.gl);
}

/// Forgets a framebuffer that was deleted.
pub fn delete(ctx: &mut Context, name: u32) {
    forget(ctx, name);
    ctx.view_copies.framebuffers.retain(|framebuffer| framebuffer.name != name);
}

/// Forgets all after a change of the views.
pub fn clear(ctx: &mut Context) {
    leave(ctx);
    let gl = ctx.driver.gl;
    for mut framebuffer in std::mem::take(&mut ctx.view_copies.framebuffers) {
        framebuffer.destroy_view_copy(gl);
    }
    let ViewCopies { images, left, deleted, issued, not_followed, .. } = &mut ctx.view_copies;
    *deleted += 1;
    not_followed.clear();
    issued.forget_views();
    for mut image in images.drain(..) {
        destroy_view_copy(&mut image, gl, ctx.driver.id, left, deleted);
    }
    ctx.view_copies.coverage.clear(gl);
    ctx.view_copies.parts.clear();
    for converter in std::mem::take(&mut ctx.view_copies.depth_converters) {
        converter.destroy(ctx.driver.gl);
    }
    for canvas in std::mem::take(&mut ctx.view_copies.canvases) {
        canvas.destroy(gl);
    }
    std::mem::take(&mut ctx.view_copies.displayed).destroy(gl);
}

/// Takes over the results of measurements that have ended.
fn take_measurements(ctx: &mut Context) {
    let gl = ctx.driver.gl;
    let mut parts = Vec::new();
    let ViewCopies { coverage, images, learnt, .. } = &mut ctx.view_copies;
    *learnt |= coverage.take_results(gl, |set, part| {
        parts.extend(part.filter(|_| set != 0));
        for (_, image) in images.iter_mut().enumerate().take(64).filter(|(i, _)| set >> i & 1 != 0) {
            image.displayed |= part.is_some();
            image.shown_small |= part.is_none();
        }
    });
    parts.into_iter().for_each(|part| _ = ctx.view_copies.parts.note(part));
}

/// Ends a frame. Images that were seen to lie between a scene and the window get view copies.
pub fn end_frame(ctx: &mut Context) {
    take_measurements(ctx);
    if !std::mem::take(&mut ctx.view_copies.learnt) || !possible(&ctx.drawable) {
        return;
    }
    let wanted = scene_graph::wanted(&ctx.view_copies.images, duplicate_mode() == Duplicate::Always);
    let mut images = ctx.view_copies.images.iter().zip(&wanted);
    if !ctx.view_copies.own_picture && images.any(|(image, wanted)| *wanted && image.read_back) {
        ctx.view_copies.own_picture = true;
        destroy_view_copies(ctx);
    }
    if !wanted.contains(&true) && ctx.view_copies.images.iter().any(|image| image.lost && image.view_copy.is_some()) {
        // A compute shader that cannot be followed was used later. The scene is flat from now on.
        destroy_view_copies(ctx);
    }
    for index in (0..wanted.len()).filter(|index| wanted[*index]) {
        make_view_copy(ctx, index);
    }
}

/// Deletes the view copies of all images.
fn destroy_view_copies(ctx: &mut Context) {
    leave(ctx);
    let gl = ctx.driver.gl;
    let ViewCopies { images, left, deleted, .. } = &mut ctx.view_copies;
    for image in images {
        destroy_view_copy(image, gl, ctx.driver.id, left, deleted);
    }
    for framebuffer in &mut ctx.view_copies.framebuffers {
        framebuffer.destroy_view_copy(gl);
    }
}

/// Makes the view copy of the image at `index`, if it has none yet. Returns true if there is one.
fn make_view_copy(ctx: &mut Context, index: usize) -> bool {
    let image = &ctx.view_copies.images[index];
    if image.view_copy.is_some() || image.refused {
        return image.view_copy.is_some();
    }
    leave(ctx);
    ctx.driver.take_errors();
    let count = copy_count(&ctx.drawable, &ctx.view_copies);
    without_scissor(ctx, |ctx| {
        let image = &mut ctx.view_copies.images[index];
        image.refused = !image.make_view_copy(ctx.driver.gl, ctx.driver.id, count);
    });
    if ctx.view_copies.images[index].refused {
        // The refusal is handled here, so the driver's errors are not needed.
        drop_errors(ctx.driver.gl);
        log::once("a scene that the program draws off screen is shown flat: the driver cannot make copies of it");
    }
    take_own_errors(&mut ctx.driver);
    !ctx.view_copies.images[index].refused
}

/// Runs `run`, which copies, with the scissor test off.
pub(super) fn without_scissor(ctx: &mut Context, run: impl FnOnce(&mut Context)) {
    ctx.set_scissor(None);
    run(ctx);
    if !ctx.redirected() && !ctx.view_copies.bound {
        ctx.restore_window_space();
    }
}

/// Copies tile `view` of the images in `set` to the program's own images.
pub(super) fn supply(ctx: &mut Context, set: Set, view: usize) {
    let has_view_copy = |ctx: &Context| {
        let images = ctx.view_copies.images.iter().enumerate().take(64);
        images.filter(|(i, _)| set >> i & 1 != 0).any(|(_, image)| image.view_copy.is_some())
    };
    if set == 0 || !has_view_copy(ctx) {
        return;
    }
    without_scissor(ctx, |ctx| {
        let images = ctx.view_copies.images.iter_mut().enumerate().take(64);
        for (_, image) in images.filter(|(i, _)| set >> i & 1 != 0) {
            image.supply(ctx.driver.gl, ctx.driver.id, view);
        }
    });
}
