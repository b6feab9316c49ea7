//! Layouts in which all tiles are as large as the program's picture, for images that compute
//! shaders read or write.

use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect};
use crate::intercept::vk::state::views::image_layout::Tiles;
use crate::lock::Lock;
use std::sync::Arc;

/// Texels between two tiles.
const GAP: u32 = 1;

impl AtlasLayout {
    /// Returns the layout for an image of `size` on its way to this window, or to a `part` of it, in
    /// which each view is as large as the image. `own_picture`: the layout must contain the program's
    /// own picture.
    pub fn even(self: &Arc<Self>, size: (u32, u32), part: Option<AtlasRect>, own_picture: bool) -> Arc<Self> {
        let mut known = self.of_images.locked();
        let fits = |known: &&Arc<Self>| {
            (known.window, known.part, known.even) == (size, part, true) && (!own_picture || known.own().is_some())
        };
        if let Some(known) = known.iter().find(fits) {
            return Arc::clone(known);
        }
        let made = Arc::new(self.with_even_tiles(size, part, own_picture));
        known.push(Arc::clone(&made));
        made
    }

    fn with_even_tiles(&self, size: (u32, u32), part: Option<AtlasRect>, own_picture: bool) -> Self {
        let own_view = self.views.iter().position(|view| view.own_lens);
        let primary = self.primary.is_some() || own_picture && own_view.is_none();
        // The tile with the program's own pixels is at the origin, so that it is rasterised in the
        // same way.
        let before = u32::from(primary);
        let count = before + self.views.len() as u32 + 1;
        let (width, height) = (size.0.max(1) + GAP, size.1.max(1) + GAP);
        let ideal = (f64::from(count) * f64::from(height) / f64::from(width)).sqrt().round() as u32;
        let columns = ideal.clamp(1, count);
        let tile = |number: u32| AtlasRect {
            x: (number % columns * width) as i32,
            y: (number / columns * height) as i32,
            width: size.0 as i32,
            height: size.1 as i32,
        };
        let first = own_view.unwrap_or(0);
        let number = |index: usize| match index {
            index if index == first => before,
            0 => before + first as u32,
            index => before + index as u32,
        };
        let tiles = Tiles {
            even: true,
            atlas: (columns * width, count.div_ceil(columns) * height),
            panel: tile(count - 1),
            primary: primary.then(|| tile(0)),
            views: (0..self.views.len()).map(|index| tile(number(index))).collect(),
        };
        self.with_tiles(size, part, tiles)
    }
}

#[cfg(test)]
mod tests {
    use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
    use crate::intercept::vk::state::views::vertices::VertexProcessing;
    use std::sync::Arc;

    #[test]
    fn even_tiles_are_apart_and_the_own_picture_is_first() {
        for (name, own_picture) in [("fisheye", false), ("fisheye", true), ("identity", false), ("planetarium-6", true)]
        {
            let rig = crate::rig::load(name).expect("a preset");
            let layout = AtlasLayout::new(&rig, (640, 360), 16384, false, VertexProcessing::Views).expect("a plan");
            let layout = Arc::new(layout);
            for size in [(640, 360), (320, 180)] {
                let even = layout.even(size, None, own_picture);
                assert!(Arc::ptr_eq(&even, &layout.even(size, None, own_picture)) && even.has_views_of(&layout));
                let tiles: Vec<_> = even.pictures().collect();
                for (index, tile) in tiles.iter().enumerate() {
                    assert_eq!((tile.width, tile.height), (size.0 as i32, size.1 as i32));
                    let (right, bottom) = (tile.x + tile.width, tile.y + tile.height);
                    assert!(right < even.atlas.0 as i32 + 1 && bottom < even.atlas.1 as i32 + 1);
                    let apart = |other: &&super::AtlasRect| {
                        (tile.x - other.x).abs() > tile.width || (tile.y - other.y).abs() > tile.height
                    };
                    assert!(tiles[..index].iter().all(|other| apart(&other)), "{name}: {tiles:?}");
                }
                let own = even.own();
                assert!(own.is_none_or(|own| (own.x, own.y) == (0, 0)) && (!own_picture || own.is_some()), "{name}");
            }
        }
    }
}
