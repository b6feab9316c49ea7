//! From window coordinates of the driver to those of the program.

use crate::correct::LowerLeftRect;

/// Window coordinates of a fragment in the program's window: those of the driver less `offset`, times `scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToWindow {
    offset: [f32; 2],
    scale: [f32; 2],
    /// Height of the program's window.
    height: f32,
    /// Height of the framebuffer that is drawn to.
    drawn_height: f32,
}

impl Default for ToWindow {
    fn default() -> Self {
        Self { offset: [0.0; 2], scale: [1.0; 2], height: 0.0, drawn_height: 0.0 }
    }
}

impl ToWindow {
    /// For a `tile` that shows what the program draws in its own window space. `drawn_height`: of the framebuffer.
    pub fn of_tile(tile: LowerLeftRect, drawn_height: i32) -> Self {
        Self {
            offset: tile.origin().map(|length| length as f32),
            scale: [1.0; 2],
            height: tile.height as f32,
            drawn_height: drawn_height as f32,
        }
    }

    /// For the `tile` of a view, which shows what the program draws in its `viewport`. The heights are those of the program's
    /// window and of the framebuffer.
    pub fn of_view(tile: LowerLeftRect, viewport: LowerLeftRect, height: i32, drawn_height: i32) -> Self {
        let (tile_size, size) = (tile.size(), viewport.size());
        let scale: [f64; 2] = std::array::from_fn(|i| f64::from(size[i].max(1)) / f64::from(tile_size[i].max(1)));
        let (from, to) = (tile.origin(), viewport.origin());
        let offset: [f64; 2] = std::array::from_fn(|i| f64::from(from[i]) - f64::from(to[i]) / scale[i]);
        Self {
            offset: offset.map(|length| length as f32),
            scale: scale.map(|length| length as f32),
            height: height as f32,
            drawn_height: drawn_height as f32,
        }
    }

    /// Offset and scale, as the shader has them. `upper_left`: it counts rows from above.
    pub fn vector(&self, upper_left: bool) -> [f32; 4] {
        let [x, y] = self.offset;
        let y = if upper_left { self.drawn_height - y - self.height / self.scale[1] } else { y };
        [x, y, self.scale[0], self.scale[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::{LowerLeftRect, ToWindow};

    fn apply([x, y, across, up]: [f32; 4], [column, row]: [f32; 2]) -> [f32; 2] {
        [(column - x) * across, (row - y) * up]
    }

    #[test]
    fn corners_of_a_tile_are_corners_of_the_window() {
        let tile = LowerLeftRect::new(300, 200, 64, 32);
        let change = ToWindow::of_tile(tile, 1000);
        assert_eq!(apply(change.vector(false), [300.5, 200.5]), [0.5, 0.5]);
        assert_eq!(apply(change.vector(true), [300.5, 1000.0 - 231.5]), [0.5, 0.5]);
        let viewport = LowerLeftRect::new(10, 20, 640, 480);
        let change = ToWindow::of_view(tile, viewport, 600, 1000);
        assert_eq!(apply(change.vector(false), [300.0, 200.0]), [10.0, 20.0]);
        assert_eq!(apply(change.vector(false), [364.0, 232.0]), [650.0, 500.0]);
        assert_eq!(apply(change.vector(true), [300.0, 1000.0 - 200.0]), [10.0, 600.0 - 20.0]);
        assert_eq!(apply(change.vector(true), [364.0, 1000.0 - 232.0]), [650.0, 600.0 - 500.0]);
    }

    #[test]
    fn what_has_no_tile_stays() {
        assert_eq!([false, true].map(|upper| ToWindow::default().vector(upper)), [[0.0, 0.0, 1.0, 1.0]; 2]);
    }
}
