//! The exact map of an output at all its pixels.

use super::accuracy::{ExactPixel, centre, compare_pixels};
use super::{MapError, PixelError, WarpMap};
use glam::DVec3;

/// All pixels of an exact map, traced once to compare several maps with it.
pub struct TracedMap {
    exact: WarpMap,
    pixels: Vec<ExactPixel>,
}

impl TracedMap {
    /// Traces all pixels of a map.
    pub fn new(exact: WarpMap) -> Self {
        let (width, height) = exact.size();
        let place = |y| (0..width).map(move |x| centre(x, y));
        let pixels = (0..height).flat_map(place).map(|pixel| ExactPixel::of(&exact, pixel)).collect();
        Self { exact, pixels }
    }

    /// The map.
    pub fn exact(&self) -> &WarpMap {
        &self.exact
    }

    /// Returns [`WarpMap::direction`] at the middle of a pixel (column and row, from the top left).
    pub fn direction(&self, x: u32, y: u32) -> Option<DVec3> {
        self.pixel(x, y).direction
    }

    /// As [`super::compare`].
    pub fn compare(&self, step: u32, map: impl FnMut(u32, u32) -> Option<DVec3>) -> MapError {
        self.compare_each(step, map, |_| {})
    }

    /// As [`super::compare_each`].
    pub fn compare_each(
        &self,
        step: u32,
        map: impl FnMut(u32, u32) -> Option<DVec3>,
        each: impl FnMut(PixelError),
    ) -> MapError {
        compare_pixels(&self.exact, |x, y| *self.pixel(x, y), step, map, each)
    }

    fn pixel(&self, x: u32, y: u32) -> &ExactPixel {
        &self.pixels[y as usize * self.exact.size().0 as usize + x as usize]
    }
}
