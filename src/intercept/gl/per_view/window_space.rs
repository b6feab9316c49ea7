//! Viewports and scissors of the program, moved to a tile.

use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::scene::to_window::ToWindow;

/// Height of what is drawn to, if that stands for the window.
fn surface_height(ctx: &Context) -> i32 {
    ctx.session().filter(|_| ctx.redirected()).map_or(0, |session| session.surface_size().1 as i32)
}

/// The tile of a view is drawn to, with the lens of the view.
pub fn view_window_space(ctx: &mut Context, tile: LowerLeftRect, scissor: Option<LowerLeftRect>) {
    let height = ctx.session().map_or(0, |session| session.window().1 as i32);
    ctx.draw.to_window = ToWindow::of_view(tile.into(), ctx.app.viewport.into(), height, surface_height(ctx));
    ctx.set_scissor(scissor);
    ctx.set_viewport(tile);
}

/// The program's own window space, for its own framebuffers and for what is drawn nowhere.
pub fn program_window_space(ctx: &mut Context) {
    ctx.draw.to_window = ToWindow::default();
}

/// The program's own viewports and scissors, moved to a tile of the window's size and kept inside
/// it.
pub fn own_window_space(ctx: &mut Context, tile: LowerLeftRect) {
    ctx.draw.to_window = ToWindow::of_tile(tile.into(), surface_height(ctx));
    if let Some(arrays) = ctx.app.arrays().map(|arrays| arrays.moved_into(tile)) {
        ctx.set_arrays(&arrays);
        return;
    }
    let LowerLeftRect { x, y, width, height } = ctx.app.viewport;
    ctx.set_viewport(LowerLeftRect::new(tile.x + x, tile.y + y, width, height));
    let inside = x >= 0 && y >= 0 && x + width <= tile.width && y + height <= tile.height;
    let scissor = if ctx.app.scissor_test {
        Some(ctx.app.scissor.moved_into(tile))
    } else if inside && !ctx.draw.wide_primitives.cut {
        None
    } else {
        Some(tile)
    };
    ctx.set_scissor(scissor);
}
