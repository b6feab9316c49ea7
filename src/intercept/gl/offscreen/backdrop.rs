//! Flat drawing that fills a scene's image before the scene is drawn: a gradient or a picture as
//! background.
//!
//! Without a change there would be a seam between any two views. So each view gets the part of this
//! picture that it sees through the program's lens. Around the picture the colours of its border
//! continue.

use crate::backend::gl::Spread;
use crate::backend::gl::driver::api;
use crate::correct::{LowerLeftRect, Size};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::offscreen::view_copies::{own_tile, views};
use crate::intercept::process::log;

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
    let (Some(copy), Some(lens)) = (&image.view_copy, ctx.frame.lens()) else { return };
    let Some(session) = ctx.drawable.session() else { return };
    // A view with a curved picture cannot be filled.
    let fills = ctx.app.viewport() == LowerLeftRect::new(0, 0, width, height);
    if !fills || session.rows(&lens).any(|reprojection| reprojection.curved) {
        return;
    }
    let (grid, format, framebuffer) = (copy.grid, image.format, framebuffer.view_copy);
    let mut tiles = std::mem::take(&mut ctx.view_copies.tiles);
    tiles.clear();
    tiles.extend(
        session.rows(&lens).enumerate().map(|(view, reprojection)| (grid.tile(view), reprojection.directions(&lens))),
    );
    debug_assert_eq!(tiles.len(), views(&ctx.drawable));
    let what = Spread {
        framebuffer,
        picture: grid.tile(own_tile(&ctx.drawable, &ctx.view_copies)),
        format,
        lens,
        tiles: &tiles,
    };
    if let Some(target) = ctx.drawable.target_mut()
        && let Err(error) = target.spread(ctx.driver.gl, &what, &ctx.driver.known_state)
    {
        log::once(&format!("the background of a scene has seams between the views: {error}"));
    }
    ctx.view_copies.tiles = tiles;
}
