//! Tiles of a view copy.

use crate::correct::{LowerLeftRect, Size};

/// Tiles of equal size, row by row from the bottom left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileGrid {
    columns: i32,
    size: Size,
}

impl TileGrid {
    pub(super) fn new(size: Size, count: usize) -> Self {
        let count = count.max(1) as i32;
        Self { columns: (1..=count).find(|columns| columns * columns >= count).unwrap_or(1), size }
    }

    /// Size of an image with `count` tiles.
    pub fn extent(&self, count: usize) -> Size {
        let rows = (count as i32 + self.columns - 1) / self.columns;
        Size::new(self.columns * self.size.width, rows * self.size.height)
    }

    /// Returns a tile.
    pub fn tile(&self, index: usize) -> LowerLeftRect {
        let (index, Size { width, height }) = (index as i32, self.size);
        LowerLeftRect::new(index % self.columns * width, index / self.columns * height, width, height)
    }
}

#[cfg(test)]
mod tests {
    use super::TileGrid;
    use crate::correct::{BlitRect, Size};

    #[test]
    fn tiles_are_apart_and_inside() {
        for count in 1..33 {
            let grid = TileGrid::new(Size::new(7, 5), count);
            let Size { width, height } = grid.extent(count);
            let all: Vec<_> = (0..count).map(|index| grid.tile(index)).collect();
            for (i, tile) in all.iter().enumerate() {
                let BlitRect { start: [x, y], end: [right, top] } = tile.corners();
                assert!(x % 7 == 0 && y % 5 == 0 && right <= width && top <= height);
                assert!(!all[..i].contains(&all[i]));
            }
        }
    }
}
