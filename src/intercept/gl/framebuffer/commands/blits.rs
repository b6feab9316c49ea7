//! `glBlitFramebuffer` from and to the window.

use crate::backend::gl::driver::api;
use crate::backend::gl::objects::framebuffers;
use crate::correct::BlitRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::framebuffer::reading::read_back;
use crate::intercept::gl::framebuffer::target::enlarge::want_panel;
use crate::intercept::gl::offscreen::displayed;
use crate::intercept::gl::offscreen::transfers;
use crate::intercept::gl::offscreen::view_copies;
use crate::intercept::gl::per_view::panel::clear_panel;
use crate::intercept::gl::per_view::window_space::own_window_space;

/// Copies a rectangle into the window: onto the flat panel and into the program's own picture.
pub fn blit(ctx: &mut Context, mut source: BlitRect, destination: BlitRect, mask: u32, filter: u32) {
    let gl = ctx.driver.gl;
    if transfers::blit(ctx, source, destination, mask, filter) {
        if ctx.redirected() {
            ctx.note_drawn();
            if let Some(target) = ctx.drawable.target_mut() {
                target.content.forget();
            }
            if let Some(part) = transfers::shown_part(ctx, source, destination) {
                displayed::note_shown(ctx, part);
            }
        }
        return;
    }
    if ctx.reads_redirected() {
        let [x, y] = read_back::prepare(ctx, source.unmirrored(), mask & api::GL_COLOR_BUFFER_BIT != 0);
        source = source.moved(x, y);
    }
    let issue = |destination: BlitRect| {
        // SAFETY: the program's own call, moved to a tile.
        unsafe { framebuffers::blit(gl, source, destination, mask, filter) };
    };
    if !ctx.redirected() {
        view_copies::leave(ctx);
        issue(destination);
        read_back::finish(ctx);
        return;
    }
    ctx.note_drawn();
    want_panel(ctx);
    let Some(target) = ctx.drawable.target() else { return };
    let in_turn = target.session.turns().is_some() && transfers::fills_window(&ctx.drawable, destination);
    let tiles = match target.own_picture().filter(|_| in_turn) {
        // The copied picture is the program's result for the present view.
        Some(tile) => [Some((tile, false)), None, None],
        None => target.flat_tiles(),
    };
    if in_turn {
        ctx.frame.note_scene();
        clear_panel(ctx);
    }
    for (tile, _) in tiles.into_iter().flatten() {
        own_window_space(ctx, tile);
        issue(destination.moved(tile.x, tile.y));
    }
    read_back::finish(ctx);
}

hooks! {
    "glBlitFramebuffer" blit_framebuffer(x0: i32, y0: i32, x1: i32, y1: i32, u0: i32, v0: i32, u1: i32, v1: i32, mask: u32, filter: u32) =
        |ctx, _gl| list_recording::now_or_later(ctx, move |ctx| {
            blit(ctx, BlitRect::new(x0, y0, x1, y1), BlitRect::new(u0, v0, u1, v1), mask, filter);
        });
}
