//! Rectangles of a rig's outputs in a window.

use super::{Output, Rig};
use crate::geom::PixelRect;

impl Rig {
    /// Rectangles of the outputs, in their order, in a window of `window` pixels. Outputs with a
    /// `window` of their own have that, cropped to the window. Otherwise a single output has the
    /// whole window, and several share it in a near-square grid, row by row from the top left. A
    /// rectangle without pixels has width or height 0; so have outputs of other machines and outputs that are not shown in
    /// the window.
    pub fn layout(&self, window: (u32, u32)) -> Vec<PixelRect> {
        let columns = self.columns();
        let rows = self.outputs_here().div_ceil(columns);
        // Cells share their borders exactly: the end of a cell is computed as the start of the next
        // one.
        let cut =
            |extent: u32, index: u32, parts: u32| (u64::from(extent) * u64::from(index) / u64::from(parts)) as u32;
        let cell = |index: u32| {
            let (column, row) = (index % columns, index / columns);
            let (x, y) = (cut(window.0, column, columns), cut(window.1, row, rows));
            PixelRect::new(x, y, cut(window.0, column + 1, columns) - x, cut(window.1, row + 1, rows) - y)
        };
        let crop = |PixelRect { x, y, width, height }| {
            let (x, y) = (x.min(window.0), y.min(window.1));
            match (width.min(window.0 - x), height.min(window.1 - y)) {
                (0, _) | (_, 0) => PixelRect::new(x, y, 0, 0),
                (width, height) => PixelRect::new(x, y, width, height),
            }
        };
        let mut cells = (0..).map(cell);
        let place = |output: &Output| match output.window {
            _ if !output.has_place() => PixelRect::new(0, 0, 0, 0),
            Some(place) => crop(place),
            None => cells.next().unwrap_or(PixelRect::new(0, 0, 0, 0)),
        };
        self.outputs.iter().map(place).collect()
    }

    /// Size in pixels of a window in which every output has its own resolution: the hull of the
    /// outputs' `window` rectangles, or the grid of their `size`. `None` if an output has neither.
    pub fn extent(&self) -> Option<(u32, u32)> {
        let here = || self.outputs.iter().filter(|output| output.has_place());
        here().next()?;
        if let Some(places) = here().map(|output| output.window).collect::<Option<Vec<_>>>() {
            let right = places.iter().map(|place| place.x.saturating_add(place.width)).max();
            let bottom = places.iter().map(|place| place.y.saturating_add(place.height)).max();
            return right.zip(bottom);
        }
        let sizes = here().map(|output| output.size).collect::<Option<Vec<_>>>()?;
        let columns = self.columns();
        let rows = (sizes.len() as u32).div_ceil(columns);
        let width = sizes.iter().map(|size| size.0).max()?;
        let height = sizes.iter().map(|size| size.1).max()?;
        Some((width.saturating_mul(columns), height.saturating_mul(rows)))
    }

    /// Number of columns of the grid of outputs, at least one.
    fn columns(&self) -> u32 {
        (1..).find(|columns| columns * columns >= self.outputs_here()).unwrap_or(1)
    }

    /// Number of outputs that the window shows.
    fn outputs_here(&self) -> u32 {
        self.outputs.iter().filter(|output| output.has_place()).count() as u32
    }
}

impl Output {
    /// True if this machine's window shows the output.
    fn has_place(&self) -> bool {
        self.here && self.shown
    }
}
