//! Flat drawing that fills the program's picture before the scene is drawn: a gradient or a picture
//! as background.
//!
//! The same picture in each view would have a seam between any two of them, and on the panel it
//! would end beside the panel. So each view gets the part of the picture that it sees through the
//! program's lens. Around the picture the colours of its border continue.

use crate::backend::gl::Spread;
use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::per_view::panel;
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::process::log;

/// The picture of a background.
pub struct Picture {
    /// Framebuffer that contains it.
    pub framebuffer: u32,
    /// Its rectangle there.
    pub rectangle: LowerLeftRect,
    /// Sized format of its colours, which can be filtered.
    pub format: u32,
}

/// Returns the tile that gets the picture of a background of the window, as the program draws it.
/// `None`: such a background cannot be spread.
pub fn tile_in_window(ctx: &Context) -> Option<LowerLeftRect> {
    let target = ctx.drawable.target()?;
    let fits = LowerLeftRect::of_size(target.size()).contains(ctx.app.viewport());
    // A view with a curved picture cannot be filled.
    let curved = target.session.views().iter().any(|view| view.curved.is_some());
    if !fits || curved || target.session.turns().is_some() || ctx.app.arrays().is_some() {
        return None;
    }
    let own = target.own_picture();
    own.or_else(|| target.panel().filter(|_| !is_blended(ctx) || cleared(target).is_some()))
}

fn is_blended(ctx: &Context) -> bool {
    ctx.driver.known_state.is_on(ctx.driver.gl, api::GL_BLEND)
}

/// Returns the colour of all views, if nothing was drawn to them since they were cleared.
fn cleared(target: &DefaultFramebuffer) -> Option<[f32; 3]> {
    let count = target.session.views().len().min(64);
    let all = target.content.views_cleared()?;
    ((0..count).all(|view| all.views >> view & 1 == 1)).then_some(all.color)
}

/// Prepares `tile` for the picture of a background. On the panel, which is transparent, a background
/// that is blended needs the colour of the program's clear.
pub fn begin_in_window(ctx: &mut Context, tile: LowerLeftRect) {
    let Some(target) = ctx.drawable.target() else { return };
    if target.panel() == Some(tile)
        && is_blended(ctx)
        && let Some(colour) = cleared(target)
    {
        ctx.set_scissor(Some(tile));
        panel::clear_to(ctx.driver.gl, &ctx.driver.known_state, colour);
    }
}

/// Gives each view its own part of the picture that was drawn to `tile` of the window.
pub fn spread_in_window(ctx: &mut Context, tile: LowerLeftRect) {
    let Some(target) = ctx.drawable.target() else { return };
    let picture = Picture {
        framebuffer: target.framebuffer(),
        rectangle: ctx.app.viewport().moved_into(tile),
        // Colours are copied as they are stored, also those of a window that converts to sRGB.
        format: api::GL_RGBA8,
    };
    let session = target.session.clone();
    spread(ctx, &picture, |view| session.tile(view));
}

/// Fills the tile of each view with its part of `picture`. Tiles with the program's own lens have it
/// already. Does nothing if a view has a curved picture.
pub fn spread(ctx: &mut Context, picture: &Picture, tile: impl Fn(usize) -> (LowerLeftRect, bool)) {
    let (Some(lens), Some(session)) = (ctx.frame.lens(), ctx.drawable.session()) else { return };
    let mut tiles = ctx.frame.background_mut().take_tiles();
    let mut curved = false;
    for (view, reprojection) in session.rows(&lens).enumerate() {
        curved |= reprojection.curved;
        let (tile, own_lens) = tile(view);
        if !own_lens {
            tiles.push((tile, reprojection.directions(&lens)));
        }
    }
    let &Picture { framebuffer, rectangle, format } = picture;
    let what = Spread { framebuffer, picture: rectangle, format, lens, tiles: &tiles };
    if !curved
        && let Some(target) = ctx.drawable.target_mut()
        && let Err(error) = target.spread(ctx.driver.gl, &what, &ctx.driver.known_state)
    {
        log::once(&format!("the background of a scene has seams between the views: {error}"));
    }
    ctx.frame.background_mut().put_tiles(tiles);
}
