//! `glBlitFramebuffer` from and to the window.

use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::framebuffer::reading::read_back;
use crate::intercept::gl::framebuffer::target::enlarge::want_panel;
use crate::intercept::gl::offscreen::transfers::{self, Corners};
use crate::intercept::gl::offscreen::view_copies;
use crate::intercept::gl::per_view::panel::clear_panel;
use crate::intercept::gl::per_view::window_space::own_window_space;

/// Copies a rectangle into the window: onto the flat panel and into the program's own picture.
pub fn blit(ctx: &mut Context, mut source: Corners, destination: Corners, mask: u32, filter: u32) {
    let gl = ctx.driver.gl;
    if transfers::blit(ctx, source, destination, mask, filter) {
        if ctx.redirected() {
            ctx.note_drawn();
            ctx.frame.note_scene();
            if let Some(target) = ctx.drawable.target_mut() {
                target.content.forget();
            }
            clear_panel(ctx);
        }
        return;
    }
    if ctx.reads_redirected() {
        let [x0, y0, x1, y1] = source;
        let part = LowerLeftRect::new(x0.min(x1), y0.min(y1), (x0 - x1).abs(), (y0 - y1).abs());
        let [x, y] = read_back::prepare(ctx, part, mask & api::GL_COLOR_BUFFER_BIT != 0);
        source = [x0 + x, y0 + y, x1 + x, y1 + y];
    }
    let issue = |[u0, v0, u1, v1]: Corners| {
        let [x0, y0, x1, y1] = source;
        // SAFETY: the program's own call, moved to a tile.
        unsafe { gl.blit_framebuffer(x0, y0, x1, y1, u0, v0, u1, v1, mask, filter) };
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
        let [x0, y0, x1, y1] = destination;
        issue([x0 + tile.x, y0 + tile.y, x1 + tile.x, y1 + tile.y]);
    }
    read_back::finish(ctx);
}

hooks! {
    "glBlitFramebuffer" blit_framebuffer(x0: i32, y0: i32, x1: i32, y1: i32, u0: i32, v0: i32, u1: i32, v1: i32, mask: u32, filter: u32) =
        |ctx, _gl| list_recording::now_or_later(ctx, move |ctx| blit(ctx, [x0, y0, x1, y1], [u0, v0, u1, v1], mask, filter));
}
