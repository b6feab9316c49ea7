//! Viewport and scissor of the program, moved to a tile.

use crate::intercept::gl::context::gl_context::Context;

/// The program's own viewport and scissor, moved to a tile of the window's size and kept inside it.
pub fn own_window_space(ctx: &mut Context, tile: [i32; 4]) {
    let [x, y, width, height] = ctx.app.viewport;
    ctx.set_viewport([tile[0] + x, tile[1] + y, width, height]);
    let inside = x >= 0 && y >= 0 && x + width <= tile[2] && y + height <= tile[3];
    let scissor = if ctx.app.scissor_test {
        Some(intersect(ctx.app.scissor, tile))
    } else if inside && !ctx.draw.wide_primitives.cut {
        None
    } else {
        Some(tile)
    };
    ctx.set_scissor(scissor);
}

/// A rectangle of the window, moved to `tile` and cut at its borders.
pub fn intersect(rect: [i32; 4], tile: [i32; 4]) -> [i32; 4] {
    let x0 = rect[0].max(0);
    let y0 = rect[1].max(0);
    let x1 = rect[0].saturating_add(rect[2]).min(tile[2]);
    let y1 = rect[1].saturating_add(rect[3]).min(tile[3]);
    [tile[0] + x0, tile[1] + y0, (x1 - x0).max(0), (y1 - y0).max(0)]
}

#[cfg(test)]
mod tests {
    use super::intersect;

    #[test]
    fn rectangles_stay_in_their_tile() {
        assert_eq!(intersect([10, 20, 30, 40], [100, 200, 300, 300]), [110, 220, 30, 40]);
        assert_eq!(intersect([-10, -20, 30, 40], [100, 200, 300, 300]), [100, 200, 20, 20]);
        assert_eq!(intersect([290, 290, 30, 40], [100, 200, 300, 300]), [390, 490, 10, 10]);
        assert_eq!(intersect([400, 400, 30, 40], [100, 200, 300, 300])[2..], [0, 0]);
        assert_eq!(intersect([i32::MAX, 0, i32::MAX, 1], [0, 0, 300, 300])[2], 0);
    }
}
