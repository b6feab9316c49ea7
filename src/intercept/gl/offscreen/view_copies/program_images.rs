//! What the program does with its images: it deletes them, uploads texels and reads them back.

use crate::correct::Size;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::offscreen::view_copies::{
    copy_count, destroy_view_copy, leave, own_tile, supply, without_scissor,
};
use crate::intercept::gl::state::offscreen::images::{Image, Name, Set};
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;

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
pub fn is_alike(view_copies: &ViewCopies, texture: u32, level: i32, size: Size) -> bool {
    let images = view_copies.images.iter();
    let mut same = images.filter(|image| matches!(image.name, Name::Texture { level: own, .. } if own == level));
    same.any(|image| image.is_texture(texture) && image.size == size)
}

/// Copies texels that the program has uploaded to a texture to the tiles of all views.
pub fn uploaded(ctx: &mut Context, texture: u32) {
    if !ctx.view_copies.images.iter().any(|image| image.is_texture(texture) && image.view_copy.is_some()) {
        return;
    }
    let count = copy_count(&ctx.drawable, &ctx.view_copies);
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
    let Some(index) = ctx.view_copies.position(ctx.app.read_framebuffer()) else { return };
    let attachments = ctx.view_copies.framebuffers[index].attachments;
    before_reading(ctx, |image| attachments.contains(&Some(image.name)));
}

fn before_reading(ctx: &mut Context, which: impl Fn(&Image) -> bool) {
    let mut set = 0;
    for (i, _) in ctx.view_copies.images.iter().enumerate().take(64).filter(|(_, image)| which(image)) {
        set |= 1 << i;
    }
    before_reading_images(&mut ctx.view_copies, set);
    supply(ctx, set, own_tile(&ctx.drawable, &ctx.view_copies));
}

/// Notes that the program reads these images. From the next frame on they have a tile that is drawn
/// with the program's own lens.
pub(in crate::intercept::gl::offscreen) fn before_reading_images(view_copies: &mut ViewCopies, set: Set) {
    for (_, image) in view_copies.images.iter_mut().enumerate().take(64).filter(|(i, _)| set >> i & 1 != 0) {
        view_copies.learnt |= !image.read_back;
        image.read_back = true;
    }
}
