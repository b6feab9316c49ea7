//! Rectangles of pixels, and sizes of pictures.

use glam::DVec2;

/// Width and height of a picture or a rectangle, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Size {
    /// Width.
    pub width: i32,
    /// Height.
    pub height: i32,
}

impl Size {
    /// Makes a size.
    pub const fn new(width: i32, height: i32) -> Self {
        Self { width, height }
    }

    /// Number of pixels.
    pub fn area(self) -> i64 {
        i64::from(self.width) * i64::from(self.height)
    }

    /// Width and height as a vector.
    pub fn to_vector(self) -> DVec2 {
        DVec2::new(self.width.into(), self.height.into())
    }
}

impl From<(u32, u32)> for Size {
    /// Lengths beyond the range saturate.
    fn from((width, height): (u32, u32)) -> Self {
        let length = |length: u32| i32::try_from(length).unwrap_or(i32::MAX);
        Self::new(length(width), length(height))
    }
}

/// Rectangle of an output in pixels; the origin is at the top left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct PixelRect {
    /// Left edge.
    pub x: u32,
    /// Top edge.
    pub y: u32,
    /// Width.
    pub width: u32,
    /// Height.
    pub height: u32,
}

impl PixelRect {
    /// Makes a rectangle from its upper left corner and its size.
    pub const fn new(x: u32, y: u32, width: u32, height: u32) -> Self {
        Self { x, y, width, height }
    }

    /// Width and height.
    pub const fn size(self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// True if both rectangles have a pixel in common.
    pub fn meets(self, other: Self) -> bool {
        meet((self.x, self.width), (other.x, other.width)) && meet((self.y, self.height), (other.y, other.height))
    }
}

/// Block of pixels of an output, given by its edges; the origin is at the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelSpan {
    /// First column.
    pub left: u32,
    /// First row.
    pub top: u32,
    /// First column to the right of the block.
    pub right: u32,
    /// First row below the block.
    pub bottom: u32,
}

impl PixelSpan {
    /// Makes a block from its edges; `right` and `bottom` are excluded.
    pub const fn new(left: u32, top: u32, right: u32, bottom: u32) -> Self {
        Self { left, top, right, bottom }
    }

    /// Positions of the edges: left, top, right, bottom.
    pub fn edges(self) -> [f64; 4] {
        [self.left, self.top, self.right, self.bottom].map(f64::from)
    }
}

/// Rectangle of pixels or texels with its origin at the lower left, as in OpenGL.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct LowerLeftRect {
    /// Left edge.
    pub x: i32,
    /// Lower edge.
    pub y: i32,
    /// Width.
    pub width: i32,
    /// Height.
    pub height: i32,
}

impl LowerLeftRect {
    /// Makes a rectangle from its lower left corner and its size.
    pub const fn new(x: i32, y: i32, width: i32, height: i32) -> Self {
        Self { x, y, width, height }
    }

    /// Rectangle of a whole picture of this size.
    pub fn of_size(size: impl Into<Size>) -> Self {
        let Size { width, height } = size.into();
        Self::new(0, 0, width, height)
    }

    /// Returns the rectangle moved by `x` and `y`; positions saturate at the limits of `i32`.
    pub const fn moved(self, x: i32, y: i32) -> Self {
        Self { x: self.x.saturating_add(x), y: self.y.saturating_add(y), ..self }
    }

    /// The lower left corner.
    pub const fn origin(self) -> [i32; 2] {
        [self.x, self.y]
    }

    /// Width and height.
    pub const fn size(self) -> Size {
        Size::new(self.width, self.height)
    }

    /// The rectangle by its lower left corner and its upper right one.
    pub const fn corners(self) -> BlitRect {
        BlitRect::new(self.x, self.y, self.x + self.width, self.y + self.height)
    }

    /// x, y, width and height, in the order in which OpenGL returns them.
    pub const fn to_array(self) -> [i32; 4] {
        [self.x, self.y, self.width, self.height]
    }

    /// True if all of `other` lies in this rectangle.
    pub fn contains(self, other: Self) -> bool {
        let holds = |start: i32, length: i32, other_start: i32, other_length: i32| {
            let end = |start: i32, length: i32| i64::from(start) + i64::from(length);
            other_start >= start && end(other_start, other_length) <= end(start, length)
        };
        holds(self.x, self.width, other.x, other.width) && holds(self.y, self.height, other.y, other.height)
    }

    /// True if both rectangles have a pixel in common.
    pub fn meets(self, other: Self) -> bool {
        meet((self.x, self.width), (other.x, other.width)) && meet((self.y, self.height), (other.y, other.height))
    }

    /// Returns the pixels that both rectangles have in common; an empty rectangle if there are none.
    pub fn intersection(self, other: Self) -> Self {
        let (x, y) = (self.x.max(other.x), self.y.max(other.y));
        let right = self.x.saturating_add(self.width).min(other.x.saturating_add(other.width));
        let top = self.y.saturating_add(self.height).min(other.y.saturating_add(other.height));
        Self::new(x, y, (right - x).max(0), (top - y).max(0))
    }

    /// True if the rectangle has more than half of the pixels of a picture of this size.
    pub fn is_most_of(self, picture: impl Into<Size>) -> bool {
        2 * self.size().area() > picture.into().area()
    }

    /// Returns this rectangle of a window, moved to the window's `tile` and cut at the tile's
    /// borders.
    pub fn moved_into(self, tile: Self) -> Self {
        let (left, bottom) = (self.x.max(0), self.y.max(0));
        let right = self.x.saturating_add(self.width).min(tile.width);
        let top = self.y.saturating_add(self.height).min(tile.height);
        Self::new(tile.x + left, tile.y + bottom, (right - left).max(0), (top - bottom).max(0))
    }
}

/// Rectangle given by two opposite corners, as in `glBlitFramebuffer`; the origin is at the lower
/// left. It is mirrored if its end is to the left of its start, or below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlitRect {
    /// The corner at which the picture starts.
    pub start: [i32; 2],
    /// The opposite corner.
    pub end: [i32; 2],
}

impl BlitRect {
    /// Makes a rectangle from its corners.
    pub const fn new(x0: i32, y0: i32, x1: i32, y1: i32) -> Self {
        Self { start: [x0, y0], end: [x1, y1] }
    }

    /// Returns the rectangle moved by `x` and `y`.
    pub const fn moved(self, x: i32, y: i32) -> Self {
        let ([x0, y0], [x1, y1]) = (self.start, self.end);
        Self::new(x0 + x, y0 + y, x1 + x, y1 + y)
    }

    /// Returns the same rectangle, not mirrored.
    pub fn unmirrored(self) -> LowerLeftRect {
        let ([x0, y0], [x1, y1]) = (self.start, self.end);
        LowerLeftRect::new(x0.min(x1), y0.min(y1), (x1 - x0).abs(), (y1 - y0).abs())
    }
}

/// Rectangle of pixels or texels with its origin at the upper left, as in Vulkan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UpperLeftRect {
    /// Left edge.
    pub x: i32,
    /// Upper edge.
    pub y: i32,
    /// Width.
    pub width: i32,
    /// Height.
    pub height: i32,
}

impl UpperLeftRect {
    /// Makes a rectangle from its upper left corner and its size.
    pub const fn new(x: i32, y: i32, width: i32, height: i32) -> Self {
        Self { x, y, width, height }
    }

    /// True if both rectangles have a pixel in common.
    pub fn meets(self, other: Self) -> bool {
        meet((self.x, self.width), (other.x, other.width)) && meet((self.y, self.height), (other.y, other.height))
    }
}

impl From<[i32; 4]> for LowerLeftRect {
    fn from([x, y, width, height]: [i32; 4]) -> Self {
        Self::new(x, y, width, height)
    }
}

/// True if two intervals, each a start and a length, have a number in common.
fn meet<T: Into<i64>>((start, length): (T, T), (other, other_length): (T, T)) -> bool {
    let (start, other) = (start.into(), other.into());
    start < other + other_length.into() && other < start + length.into()
}

/// True if no two of these rectangles have a pixel in common. `meets` tests two of them.
pub fn apart<R: Copy>(rectangles: &[R], meets: impl Fn(R, R) -> bool) -> bool {
    (1..=rectangles.len()).all(|next| {
        let (earlier, one) = (&rectangles[..next - 1], rectangles[next - 1]);
        !earlier.iter().any(|other| meets(*other, one))
    })
}

#[cfg(test)]
mod tests {
    use super::LowerLeftRect;

    #[test]
    fn rectangles_stay_in_their_tile() {
        let moved = |rect: [i32; 4], tile: [i32; 4]| LowerLeftRect::from(rect).moved_into(tile.into()).to_array();
        assert_eq!(moved([10, 20, 30, 40], [100, 200, 300, 300]), [110, 220, 30, 40]);
        assert_eq!(moved([-10, -20, 30, 40], [100, 200, 300, 300]), [100, 200, 20, 20]);
        assert_eq!(moved([290, 290, 30, 40], [100, 200, 300, 300]), [390, 490, 10, 10]);
        assert_eq!(moved([400, 400, 30, 40], [100, 200, 300, 300])[2..], [0, 0]);
        assert_eq!(moved([i32::MAX, 0, i32::MAX, 1], [0, 0, 300, 300])[2], 0);
    }
}
