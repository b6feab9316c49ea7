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

use crate::backend::gl::driver::api::Gl;
use crate::backend::gl::objects::framebuffers::FramebufferBindings;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::errors::{drop_errors, take_own_errors};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::offscreen::scene_graph;
use crate::intercept::gl::per_view::window_space::own_window_space;
use crate::intercept::gl::state::offscreen::framebuffers::{self, Framebuffer};
use crate::intercept::gl::state::offscreen::images::{Image, Name, Pair, Set};
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
pub(super) fn possible(ctx: &Context) -> bool {
    let has_other_lenses = |s: &Session| s.turns().is_none() && s.views().iter().any(|v| !v.program_lens);
    duplicate_mode() != Duplicate::Never && ctx.session().is_some_and(has_other_lenses)
}

/// Returns the number of views.
pub(super) fn views(ctx: &Context) -> usize {
    ctx.session().map_or(0, |session| session.views().len())
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
    own.left.extend(taken.left);
    let (gl, id) = (ctx.driver.gl, ctx.driver.id);
    ctx.view_copies.left.retain(|pair| {
        if pair.context == id {
            pair.destroy(gl);
        }
        pair.context != id
    });
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
pub(super) fn copy_count(ctx: &Context) -> usize {
    views(ctx) + usize::from(ctx.view_copies.own_picture)
}

/// Returns the tile of the program's own picture. If there is none, returns the tile of the view
/// ahead.
pub(super) fn own_tile(ctx: &Context) -> usize {
    let ahead = || ctx.session().map_or(0, |session| session.ahead());
    if ctx.view_copies.own_picture { views(ctx) } else { ahead() }
}

/// Binds the program's own draw framebuffer again, for calls that use its binding.
pub fn leave(ctx: &mut Context) {
    if std::mem::take(&mut ctx.view_copies.bound) {
        // SAFETY: what the program bound.
        unsafe {
            ctx.driver
                .gl
                .bind_framebuffer(crate::backend::gl::driver::api::GL_DRAW_FRAMEBUFFER, ctx.app.draw_framebuffer)
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
    if ctx.app.draw_framebuffer == name {
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

/// Forgets the images for which `which` returns true. They were deleted, or got another size or
/// format.
fn forget_images(ctx: &mut Context, which: impl Fn(&Image) -> bool) {
    while let Some(index) = ctx.view_copies.images.iter().position(&which) {
        leave(ctx);
        let mut image = ctx.view_copies.images.remove(index);
        let ViewCopies { left, deleted, .. } = &mut ctx.view_copies;
        // The places of images in the list change, even if the image had no view copy.
        *deleted += u64::from(image.view_copy.is_none());
        destroy_view_copy(&mut image, ctx.driver.gl, ctx.driver.id, left, deleted);
        for framebuffer in &mut ctx.view_copies.framebuffers {
            if framebuffer.attachments.contains(&Some(image.name)) {
                framebuffer.known = false;
                framebuffer.destroy_view_copy(ctx.driver.gl);
            }
        }
        // Coverage identifies images by their places in the list.
        ctx.view_copies.coverage.clear(ctx.driver.gl);
    }
}

/// Does the same as `forget_images` for a texture.
pub fn forget_texture(ctx: &mut Context, texture: u32) {
    forget_images(ctx, |image| image.is_texture(texture));
    // If no image is followed, deletions are not seen.
    let followed = ctx.view_copies.any();
    ctx.view_copies.not_followed.retain(|(name, _)| followed && *name != texture);
}

/// Does the same as `forget_images` for a renderbuffer.
pub fn forget_renderbuffer(ctx: &mut Context, renderbuffer: u32) {
    forget_images(ctx, |image| image.name == Name::Renderbuffer(renderbuffer));
}

/// True if a followed texture has this size and format already, so that nothing changes.
pub fn is_alike(ctx: &Context, texture: u32, level: i32, size: [i32; 2]) -> bool {
    let images = ctx.view_copies.images.iter();
    let mut same = images.filter(|image| matches!(image.name, Name::Texture { level: own, .. } if own == level));
    same.any(|image| image.is_texture(texture) && image.size == size)
}

/// Copies texels that the program has uploaded to a texture to the tiles of all views.
pub fn uploaded(ctx: &mut Context, texture: u32) {
    if !ctx.view_copies.images.iter().any(|image| image.is_texture(texture) && image.view_copy.is_some()) {
        return;
    }
    let count = copy_count(ctx);
    without_scissor(ctx, |ctx| {
        for image in ctx.view_copies.images.iter_mut().filter(|image| image.is_texture(texture)) {
            for index in 0..count {
                image.store(ctx.driver.gl, ctx.driver.id, index);
            }
        }
    });
}

/// Notes that the program generates mipmaps of a texture. Returns true if Cupola generates them
/// when the texture is sampled.
pub fn mipmaps(view_copies: &mut ViewCopies, texture: u32) -> bool {
    let mut view_copy = false;
    for image in view_copies.images.iter_mut().filter(|image| image.is_texture(texture)) {
        image.mipmapped = true;
        image.changed();
        view_copy |= image.view_copy.is_some();
    }
    view_copy
}

/// Gives a texture its own picture before the program reads it.
pub fn before_reading_texture(ctx: &mut Context, texture: u32) {
    before_reading(ctx, |image| image.is_texture(texture));
}

/// Gives the images of the read framebuffer their own picture before the program reads it.
pub fn before_reading_framebuffer(ctx: &mut Context) {
    let Some(index) = ctx.view_copies.position(ctx.app.read_framebuffer) else { return };
    let attachments = ctx.view_copies.framebuffers[index].attachments;
    before_reading(ctx, |image| attachments.contains(&Some(image.name)));
}

fn before_reading(ctx: &mut Context, which: impl Fn(&Image) -> bool) {
    let mut set = 0;
    for (i, _) in ctx.view_copies.images.iter().enumerate().take(64).filter(|(_, image)| which(image)) {
        set |= 1 << i;
    }
    before_reading_images(ctx, set);
    supply(ctx, set, own_tile(ctx));
}

/// Notes that the program reads these images. From the next frame on they have a tile that is drawn
/// with the program's own lens.
pub(super) fn before_reading_images(ctx: &mut Context, set: Set) {
    for (_, image) in ctx.view_copies.images.iter_mut().enumerate().take(64).filter(|(i, _)| set >> i & 1 != 0) {
        ctx.view_copies.learnt |= !image.read_back;
        image.read_back = true;
    }
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
    for converter in std::mem::take(&mut ctx.view_copies.depth_converters) {
        converter.destroy(ctx.driver.gl);
    }
    for canvas in std::mem::take(&mut ctx.view_copies.canvases) {
        canvas.destroy(gl);
    }
    std::mem::take(&mut ctx.view_copies.displayed).destroy(gl);
}

/// Ends a frame. Images that were seen to lie between a scene and the window get view copies.
pub fn end_frame(ctx: &mut Context) {
    let gl = ctx.driver.gl;
    let ViewCopies { coverage, images, learnt, .. } = &mut ctx.view_copies;
    *learnt |= coverage.end_frame(gl, |set| {
        for image in images.iter_mut().enumerate().take(64).filter(|(i, _)| set >> i & 1 != 0).map(|(_, image)| image) {
            image.displayed = true;
        }
    });
    if !std::mem::take(&mut ctx.view_copies.learnt) || !possible(ctx) {
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
    let count = copy_count(ctx);
    without_scissor(ctx, |ctx| {
        let image = &mut ctx.view_copies.images[index];
        image.refused = !image.make_view_copy(ctx.driver.gl, ctx.driver.id, count);
    });
    if ctx.view_copies.images[index].refused {
        // The refusal is handled here, so the driver's errors are not needed.
        drop_errors(ctx.driver.gl);
        log::once("a scene that the program draws off screen is shown flat: the driver cannot make copies of it");
    }
    take_own_errors(&ctx.driver, &mut ctx.frame.counts);
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

/// Returns the index of the program's draw framebuffer. Examines its attachments if they are not
/// known.
pub(super) fn look(ctx: &mut Context) -> usize {
    let name = ctx.app.draw_framebuffer;
    let index = ctx.view_copies.position(name).unwrap_or_else(|| {
        ctx.view_copies.framebuffers.push(Framebuffer::new(name));
        ctx.view_copies.framebuffers.len() - 1
    });
    if !ctx.view_copies.framebuffers[index].known {
        leave(ctx);
        ctx.driver.take_errors();
        let ViewCopies { framebuffers, images, .. } = &mut ctx.view_copies;
        framebuffers[index].examine(ctx.driver.gl, images);
        // The examination asks questions that some drivers do not know. Their errors have no
        // meaning.
        drop_errors(ctx.driver.gl);
    }
    index
}

/// Examines the attachments of the program's read framebuffer, if compute shaders may have written
/// its images. In that case no draw has examined it.
pub(super) fn look_at_read(ctx: &mut Context) {
    let name = ctx.app.read_framebuffer;
    if !ctx.view_copies.computes || name == 0 || name == ctx.app.draw_framebuffer {
        return;
    }
    let index = ctx.view_copies.position(name).unwrap_or_else(|| {
        ctx.view_copies.framebuffers.push(Framebuffer::new(name));
        ctx.view_copies.framebuffers.len() - 1
    });
    if ctx.view_copies.framebuffers[index].known {
        return;
    }
    ctx.driver.take_errors();
    let ViewCopies { framebuffers, images, .. } = &mut ctx.view_copies;
    // SAFETY: a framebuffer of the program; the bindings are put back.
    unsafe {
        let bindings = FramebufferBindings::save(ctx.driver.gl);
        ctx.driver.gl.bind_framebuffer(crate::backend::gl::driver::api::GL_DRAW_FRAMEBUFFER, name);
        framebuffers[index].examine(ctx.driver.gl, images);
        bindings.restore(ctx.driver.gl);
    }
    drop_errors(ctx.driver.gl);
}

/// Replaces the program's draw framebuffer, which is at `index`, by its view copy. Returns false if
/// it has none.
pub(super) fn enter(ctx: &mut Context, index: usize) -> bool {
    if ctx.view_copies.bound {
        return true;
    }
    if !ctx.view_copies.has_view_copies(&ctx.view_copies.framebuffers[index]) {
        return false;
    }
    if ctx.view_copies.framebuffers[index].view_copy == 0 && !make_framebuffer(ctx, index) {
        return false;
    }
    ctx.view_copies.bound = true;
    let view_copy = ctx.view_copies.framebuffers[index].view_copy;
    // SAFETY: a framebuffer of Cupola; `leave` binds the program's again.
    unsafe { ctx.driver.gl.bind_framebuffer(crate::backend::gl::driver::api::GL_DRAW_FRAMEBUFFER, view_copy) };
    true
}

/// Makes the framebuffer that replaces the one at `index`, with view copies of all attached images.
pub(super) fn make_framebuffer(ctx: &mut Context, index: usize) -> bool {
    let attached = ctx.view_copies.framebuffers[index].attachments;
    let places: [Option<usize>; framebuffers::COLOURS + 2] =
        attached.map(|name| name.and_then(|name| ctx.view_copies.images.iter().position(|image| image.name == name)));
    let mut complete = places.into_iter().flatten().all(|place| make_view_copy(ctx, place));
    ctx.driver.take_errors();
    if complete {
        let ViewCopies { framebuffers, images, .. } = &mut ctx.view_copies;
        let view_copy_of = |name| {
            let image = images.iter().find(|image| image.name == name);
            image.and_then(|image| image.view_copy.as_ref()).map(|view_copy| view_copy.renderbuffer)
        };
        complete = framebuffers[index].make_view_copy(ctx.driver.gl, view_copy_of);
        drop_errors(ctx.driver.gl);
    }
    if !complete {
        ctx.view_copies.framebuffers[index].obstacle = Some("the driver cannot make copies of it".into());
        log::once("a scene that the program draws off screen is shown flat: the driver cannot make copies of it");
    }
    complete
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

/// Runs a clear of a framebuffer of the program. Returns false if the framebuffer is drawn only
/// once.
pub fn clear_with(ctx: &mut Context, issue: &dyn Fn(&Gl)) -> bool {
    if ctx.app.draw_framebuffer == 0 || ctx.app.picking || !possible(ctx) {
        return false;
    }
    let index = look(ctx);
    // A clear of a part, as for a picture in a corner, does not remove the scene.
    let name = ctx.view_copies.framebuffers[index].images().next();
    let size = name.and_then(|name| ctx.view_copies.image(name)).map_or([0; 2], |image| image.size);
    let part = ctx.app.scissor_test && !ctx.app.scissor.contains(LowerLeftRect::new(0, 0, size[0], size[1]));
    ctx.view_copies.framebuffers[index].has_scene &= part;
    if !enter(ctx, index) {
        return false;
    }
    ctx.view_copies.changed(index);
    let gl = ctx.driver.gl;
    if !ctx.app.scissor_test {
        ctx.set_scissor(None);
        issue(gl);
        return true;
    }
    let first = ctx.view_copies.framebuffers[index].images().next();
    let grid = first.and_then(|name| Some(ctx.view_copies.image(name)?.view_copy.as_ref()?.grid));
    for view in 0..copy_count(ctx) {
        if let Some(grid) = grid {
            own_window_space(ctx, grid.tile(view));
            issue(gl);
        }
    }
    true
}
