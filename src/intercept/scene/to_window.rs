//! Converts window coordinates of the driver to those of the program.

use crate::correct::LowerLeftRect;
use glam::{DVec2, Vec2};

/// A rectangle in window coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Corner with the smallest coordinates.
    pub origin: Vec2,
    /// Width and height.
    pub size: Vec2,
}

impl From<LowerLeftRect> for Area {
    fn from(rect: LowerLeftRect) -> Self {
        let LowerLeftRect { x, y, width, height } = rect;
        Self { origin: Vec2::new(x as f32, y as f32), size: Vec2::new(width as f32, height as f32) }
    }
}

/// Conversion of a fragment's position to the program's window: subtract `offset` from the driver's
/// window coordinates, then multiply by `scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToWindow {
    offset: Vec2,
    scale: Vec2,
    /// Height of the program's window.
    height: f32,
    /// Height of the framebuffer that is drawn to.
    drawn_height: f32,
}

impl Default for ToWindow {
    fn default() -> Self {
        Self { offset: Vec2::ZERO, scale: Vec2::ONE, height: 0.0, drawn_height: 0.0 }
    }
}

impl ToWindow {
    /// Returns the conversion for a `tile` that shows the program's own window space.
    /// `drawn_height`: height of the framebuffer.
    pub fn of_tile(tile: Area, drawn_height: i32) -> Self {
        Self { offset: tile.origin, scale: Vec2::ONE, height: tile.size.y, drawn_height: drawn_height as f32 }
    }

    /// Returns the conversion for the `tile` of a view that shows the program's `viewport`.
    /// `height`: of the program's window. `drawn_height`: of the framebuffer.
    pub fn of_view(tile: Area, viewport: Area, height: i32, drawn_height: i32) -> Self {
        let factor = |length: f32, shown: f32| {
            if length > 0.0 && shown > 0.0 { f64::from(length) / f64::from(shown) } else { 1.0 }
        };
        let scale = DVec2::new(factor(viewport.size.x, tile.size.x), factor(viewport.size.y, tile.size.y));
        let offset = tile.origin.as_dvec2() - viewport.origin.as_dvec2() / scale;
        Self {
            offset: offset.as_vec2(),
            scale: scale.as_vec2(),
            height: height as f32,
            drawn_height: drawn_height as f32,
        }
    }

    /// Returns offset and scale in the form of the shader. `upper_left`: the shader counts rows
    /// from above.
    pub fn vector(&self, upper_left: bool) -> [f32; 4] {
        let (Vec2 { x, y }, scale) = (self.offset, self.scale);
        let y = if upper_left { self.drawn_height - y - self.height / scale.y } else { y };
        [x, y, scale.x, scale.y]
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
        let change = ToWindow::of_tile(tile.into(), 1000);
        assert_eq!(apply(change.vector(false), [300.5, 200.5]), [0.5, 0.5]);
        assert_eq!(apply(change.vector(true), [300.5, 1000.0 - 231.5]), [0.5, 0.5]);
        let viewport = LowerLeftRect::new(10, 20, 640, 480);
        let change = ToWindow::of_view(tile.into(), viewport.into(), 600, 1000);
        // A 32-bit number near 800 has an error of 0.00003, which is multiplied by 15.
        let expect = |upper_left: bool, at: [f32; 2], expected: [f32; 2]| {
            let found = apply(change.vector(upper_left), at);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{found:?}, not {expected:?}");
        };
        expect(false, [300.0, 200.0], [10.0, 20.0]);
        expect(false, [364.0, 232.0], [650.0, 500.0]);
        expect(true, [300.0, 1000.0 - 200.0], [10.0, 600.0 - 20.0]);
        expect(true, [364.0, 1000.0 - 232.0], [650.0, 600.0 - 500.0]);
    }

    #[test]
    fn what_has_no_tile_stays() {
        assert_eq!([false, true].map(|upper| ToWindow::default().vector(upper)), [[0.0, 0.0, 1.0, 1.0]; 2]);
    }
}
