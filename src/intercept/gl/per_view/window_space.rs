//! Viewports and scissors of the program, moved to a tile.

use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::state::draw::DrawState;
use crate::intercept::scene::to_window::ToWindow;

/// Returns the height of the stand-in image if drawing goes to it, else 0.
fn surface_height(ctx: &Context) -> i32 {
    ctx.session().filter(|_| ctx.redirected()).map_or(0, |session| session.surface_size().1 as i32)
}

/// Sets the window space for a view's tile, with the lens of the view.
pub fn view_window_space(ctx: &mut Context, tile: LowerLeftRect, scissor: Option<LowerLeftRect>) {
    let height = ctx.session().map_or(0, |session| session.window().1 as i32);
    ctx.draw.note_window_space(ToWindow::of_view(tile.into(), ctx.app.viewport().into(), height, surface_height(ctx)));
    ctx.set_scissor(scissor);
    ctx.set_viewport(tile);
}

/// Sets the program's own window space, for its own framebuffers and for draws that reach no image.
pub fn program_window_space(draw: &mut DrawState) {
    draw.note_window_space(ToWindow::default());
}

/// Moves the program's own viewports and scissors to a tile of the window's size, and limits them
/// to it.
pub fn own_window_space(ctx: &mut Context, tile: LowerLeftRect) {
    ctx.draw.note_window_space(ToWindow::of_tile(tile.into(), surface_height(ctx)));
    if let Some(arrays) = ctx.app.arrays().map(|arrays| arrays.moved_into(tile)) {
        ctx.set_arrays(&arrays);
        return;
    }
    let LowerLeftRect { x, y, width, height } = ctx.app.viewport();
    ctx.set_viewport(LowerLeftRect::new(tile.x + x, tile.y + y, width, height));
    let inside = x >= 0 && y >= 0 && x + width <= tile.width && y + height <= tile.height;
    let scissor = if ctx.app.scissor_test() {
        Some(ctx.app.scissor().moved_into(tile))
    } else if inside && !ctx.draw.is_cut() {
        None
    } else {
        Some(tile)
    };
    ctx.set_scissor(scissor);
}
