//! Flat drawing that fills a scene's image before the scene is drawn ([`per_view::backdrop`]).

use crate::backend::gl::driver::api;
use crate::correct::{LowerLeftRect, Size};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::offscreen::view_copies::own_tile;
use crate::intercept::gl::per_view;
use crate::intercept::gl::per_view::backdrop::Picture;

/// Formats of colours that can be copied and filtered directly.
const FORMATS: [u32; 9] = [
    api::GL_RGBA8,
    api::GL_RGB8,
    api::GL_RGB10_A2,
    api::GL_RGBA16,
    api::GL_RGBA16F,
    api::GL_RGB16F,
    api::GL_RGBA32F,
    api::GL_RGB32F,
    api::GL_R11F_G11F_B10F,
];

/// Gives each view its own part of a background. The draw before this call filled each tile of the
/// bound framebuffer `index` with the same picture. Does nothing if the framebuffer has a scene
/// already.
pub(super) fn spread(ctx: &mut Context, index: usize) {
    let framebuffer = &ctx.view_copies.framebuffers[index];
    let mut colours = framebuffer.colours();
    let (Some(name), None, false) = (colours.next(), colours.next(), framebuffer.has_scene) else { return };
    let Some(image) = ctx.view_copies.image(name).filter(|image| FORMATS.contains(&image.format)) else { return };
    let Size { width, height } = image.size;
    let Some(copy) = &image.view_copy else { return };
    if ctx.app.viewport() != LowerLeftRect::new(0, 0, width, height) {
        return;
    }
    let (grid, format, framebuffer) = (copy.grid, image.format, framebuffer.view_copy);
    let rectangle = grid.tile(own_tile(&ctx.drawable, &ctx.view_copies));
    drop(colours);
    let picture = Picture { framebuffer, rectangle, format };
    per_view::backdrop::spread(ctx, &picture, |view| (grid.tile(view), false));
}
