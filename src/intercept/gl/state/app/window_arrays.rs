//! Viewports and scissors by index (OpenGL 4.1), if the program has set them separately.

use crate::correct::LowerLeftRect;

/// Number of indices that Cupola follows: the least number that OpenGL allows, and the usual number
/// of drivers.
pub const COUNT: usize = 16;

/// A viewport with fractions, as OpenGL has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Viewport {
    /// Left edge.
    pub x: f32,
    /// Lower edge.
    pub y: f32,
    /// Width, at least 0.
    pub width: f32,
    /// Height, at least 0.
    pub height: f32,
}

impl Viewport {
    /// Returns the viewport in a picture whose lower left corner is at `[x, y]`.
    fn moved_by(self, [x, y]: [i32; 2]) -> Self {
        Self { x: self.x + x as f32, y: self.y + y as f32, ..self }
    }

    /// Returns x, y, width and height, in OpenGL's order.
    pub const fn to_array(self) -> [f32; 4] {
        [self.x, self.y, self.width, self.height]
    }

    /// Returns the viewport, rounded to whole pixels.
    pub fn rounded(self) -> LowerLeftRect {
        self.to_array().map(|v| v.round() as i32).into()
    }
}

impl From<[f32; 4]> for Viewport {
    fn from([x, y, width, height]: [f32; 4]) -> Self {
        Self { x, y, width, height }
    }
}

impl From<LowerLeftRect> for Viewport {
    fn from(rect: LowerLeftRect) -> Self {
        rect.to_array().map(|v| v as f32).into()
    }
}

/// Viewports, scissors and scissor tests of all indices.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowArrays {
    /// Viewports.
    pub viewports: [Viewport; COUNT],
    /// Scissors.
    pub scissors: [LowerLeftRect; COUNT],
    /// Scissor tests, a bit for each index.
    pub tests: u16,
}

impl WindowArrays {
    /// Returns the same viewport, scissor and test for all indices.
    pub fn alike(viewport: LowerLeftRect, scissor: LowerLeftRect, test: bool) -> Self {
        Self { viewports: [viewport.into(); COUNT], scissors: [scissor; COUNT], tests: if test { u16::MAX } else { 0 } }
    }

    /// True if drawing with one index differs from drawing with another one.
    pub fn differ(&self) -> bool {
        self.viewports.iter().any(|viewport| *viewport != self.viewports[0])
            || self.scissors.iter().any(|scissor| *scissor != self.scissors[0])
            || (self.tests != 0 && self.tests != u16::MAX)
    }

    /// Returns the viewports and scissors moved into `tile`. The scissors limit all drawing to the
    /// tile.
    pub fn moved_into(&self, tile: LowerLeftRect) -> Self {
        let scissor = |index: usize| match self.tests >> index & 1 {
            0 => tile,
            _ => self.scissors[index].moved_into(tile),
        };
        Self {
            viewports: self.viewports.map(|viewport| viewport.moved_by(tile.origin())),
            scissors: std::array::from_fn(scissor),
            tests: u16::MAX,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Viewport, WindowArrays};
    use crate::correct::LowerLeftRect;

    #[test]
    fn arrays_move_into_a_tile_and_stay_there() {
        let mut arrays = WindowArrays::alike(LowerLeftRect::new(0, 0, 60, 40), LowerLeftRect::new(1, 2, 3, 4), false);
        assert!(!arrays.differ());
        arrays.viewports[1] = Viewport { x: 30.5, y: -2.0, width: 30.0, height: 20.25 };
        arrays.tests = 2;
        assert!(arrays.differ());
        let tile = LowerLeftRect::new(100, 200, 60, 40);
        let moved = arrays.moved_into(tile);
        assert_eq!(moved.viewports[0], tile.into());
        assert_eq!(moved.viewports[1], Viewport { x: 130.5, y: 198.0, width: 30.0, height: 20.25 });
        assert_eq!(moved.scissors[..2], [tile, LowerLeftRect::new(101, 202, 3, 4)]);
        assert_eq!(moved.tests, u16::MAX, "all drawing is cut at the tile");
    }

    #[test]
    fn each_part_can_differ() {
        let alike = WindowArrays::alike(LowerLeftRect::new(0, 0, 6, 4), LowerLeftRect::new(0, 0, 6, 4), true);
        assert!(!alike.differ());
        assert!(WindowArrays { tests: 1, ..alike.clone() }.differ());
        let mut other = alike.clone();
        other.scissors[15].x = 1;
        assert!(other.differ());
        let mut fractions = alike;
        fractions.viewports = [Viewport { x: 0.5, ..fractions.viewports[0] }; super::COUNT];
        assert!(!fractions.differ(), "all are alike");
    }
}
