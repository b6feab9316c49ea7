//! Viewports and scissors of the program, moved to a tile.

use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;

/// The program's own viewports and scissors, moved to a tile of the window's size and kept inside it.
pub fn own_window_space(ctx: &mut Context, tile: LowerLeftRect) {
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
