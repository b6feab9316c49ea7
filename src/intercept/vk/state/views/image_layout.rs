//! Layouts for images of other sizes on their way to the window, or to a part of it.

use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect, ViewTile};
use crate::lock::Lock;
use std::sync::{Arc, Mutex};

/// Tiles of a layout.
pub(super) struct Tiles {
    /// True if all are as large as the program's picture.
    pub even: bool,
    /// Size of the atlas.
    pub atlas: (u32, u32),
    pub panel: AtlasRect,
    pub primary: Option<AtlasRect>,
    pub views: Vec<AtlasRect>,
}

impl AtlasLayout {
    /// Returns the layout for an image of `size` on its way to this window, or to a `part` of it.
    /// Its tiles are scaled by the same ratio, but only as far as an image of `most` texels in width
    /// and height has room for them.
    pub fn of_image(self: &Arc<Self>, size: (u32, u32), part: Option<AtlasRect>, most: u32) -> Arc<Self> {
        if size == self.window && part.is_none() {
            return Arc::clone(self);
        }
        let mut known = self.of_images.locked();
        let fits = |known: &&Arc<Self>| known.window == size && known.part == part && !known.even;
        if let Some(known) = known.iter().find(fits) {
            return Arc::clone(known);
        }
        let made = Arc::new(self.scaled(size, part, most));
        known.push(Arc::clone(&made));
        made
    }

    /// Returns the number of pixels of an image of `size` divided by the number of this window's
    /// that it fills.
    fn pixels_of(&self, size: (u32, u32), part: Option<AtlasRect>) -> f64 {
        let filled = self.filled(part);
        f64::from(size.0) * f64::from(size.1) / (f64::from(filled.0) * f64::from(filled.1))
    }

    /// Returns the size of a part of the window; `None`: of all of it.
    fn filled(&self, part: Option<AtlasRect>) -> (u32, u32) {
        part.map_or(self.window, |part| (part.width.max(1) as u32, part.height.max(1) as u32))
    }

    fn scaled(&self, size: (u32, u32), part: Option<AtlasRect>, most: u32) -> Self {
        let filled = self.filled(part);
        // A tile with the program's own pixels has exactly the size of the program's picture.
        let exact = self.own().is_some() || self.views.iter().any(|view| view.own_lens);
        let scale = |own: u32, filled: u32, atlas: u32| {
            let ideal = f64::from(own) / f64::from(filled.max(1));
            if exact { ideal } else { ideal.min(f64::from(most) / f64::from(atlas.max(1))) }
        };
        let across = scale(size.0, filled.0, self.atlas.0);
        let down = scale(size.1, filled.1, self.atlas.1);
        let rect = |tile: AtlasRect| {
            let ends = |start: i32, length: i32, scale: f64| {
                let [start, end] = [start, start + length].map(|place| (f64::from(place) * scale).round() as i32);
                (start, (end - start).max(1))
            };
            let ((x, width), (y, height)) = (ends(tile.x, tile.width, across), ends(tile.y, tile.height, down));
            AtlasRect { x, y, width, height }
        };
        // A part of the window has smaller pictures than the window.
        let picture = |tile: AtlasRect| {
            let AtlasRect { x, y, width, height } = rect(tile);
            AtlasRect { x, y, width: width.min(size.0 as i32), height: height.min(size.1 as i32) }
        };
        // The last tile may be one texel wide and begin at the end.
        let length = |atlas: u32, scale: f64| {
            let length = (f64::from(atlas) * scale).ceil() as u32 + 1;
            if exact { length } else { length.min(most) }
        };
        let tiles = Tiles {
            even: false,
            atlas: (length(self.atlas.0, across), length(self.atlas.1, down)),
            panel: picture(self.panel),
            primary: self.primary.map(picture),
            views: self.views.iter().map(|view| rect(view.rect)).collect(),
        };
        self.with_tiles(size, part, tiles)
    }

    /// Returns the layout with these tiles for an image of `size` on its way to the window, or to a
    /// `part` of it.
    pub(super) fn with_tiles(&self, size: (u32, u32), part: Option<AtlasRect>, tiles: Tiles) -> Self {
        let Tiles { even, atlas, panel, primary, views } = tiles;
        let views = self.views.iter().zip(views).map(|(view, rect)| ViewTile { rect, ..*view });
        Self {
            session: Arc::clone(&self.session),
            plan: self.plan.clone(),
            version: self.version,
            window: size,
            pixels: self.pixels_of(size, part),
            part,
            even,
            of_images: Mutex::default(),
            atlas,
            panel,
            primary,
            read: self.read,
            views: views.collect(),
            lenses: self.lenses.clone(),
            outputs: self.outputs.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{AtlasLayout, AtlasRect};
    use crate::intercept::vk::state::views::vertices::VertexProcessing;
    use std::sync::Arc;

    /// Tiles of another size do not overlap, lie within the atlas, and take the same parts of it.
    #[test]
    fn images_of_other_sizes_have_the_same_tiles() {
        let rig = crate::rig::load("fisheye").expect("a preset");
        for read in [false, true] {
            let layout = AtlasLayout::new(&rig, (640, 360), 16384, read, VertexProcessing::Divided);
            let layout = Arc::new(layout.expect("a plan"));
            assert!(Arc::ptr_eq(&layout.of_image((640, 360), None, 16384), &layout));
            for size in [(320, 180), (1280, 720), (80, 45), (427, 240)] {
                let other = layout.of_image(size, None, 16384);
                assert!(Arc::ptr_eq(&layout.of_image(size, None, 16384), &other) && other.has_views_of(&layout));
                assert_eq!(
                    other.own().map(|own| (own.x, own.y, own.width, own.height)),
                    layout.own().map(|_| { (0, 0, size.0 as i32, size.1 as i32) })
                );
                let tiles: Vec<_> = other.pictures().collect();
                let scale = f64::from(size.0) / 640.0;
                for (index, (tile, of_window)) in tiles.iter().zip(layout.pictures()).enumerate() {
                    assert!((f64::from(of_window.width) * scale - f64::from(tile.width)).abs() <= 1.0, "{tile:?}");
                    assert!(
                        tile.x + tile.width <= other.atlas.0 as i32 && tile.y + tile.height <= other.atlas.1 as i32
                    );
                    for earlier in &tiles[..index] {
                        let apart = |a: i32, length: i32, b: i32, other: i32| a + length <= b || b + other <= a;
                        assert!(
                            apart(tile.x, tile.width, earlier.x, earlier.width)
                                || apart(tile.y, tile.height, earlier.y, earlier.height),
                            "{size:?}: {tile:?} {earlier:?}"
                        );
                    }
                }
            }
        }
        let layout = AtlasLayout::new(&rig, (640, 360), 16384, false, VertexProcessing::Divided);
        let layout = Arc::new(layout.expect("a plan"));
        let small = layout.of_image((6400, 3600), None, layout.atlas.0 + 10);
        assert!(small.atlas.0 <= layout.atlas.0 + 10 && small.views[0].rect.width >= layout.views[0].rect.width);
    }

    /// The image of a part of the window fills views that are as large as those of the window. The
    /// program's own picture is as large as the image.
    #[test]
    fn an_image_of_a_part_has_the_views_of_the_window() {
        let rig = crate::rig::load("fisheye").expect("a preset");
        let part = AtlasRect { x: 100, y: 20, width: 500, height: 320 };
        for read in [false, true] {
            let layout = AtlasLayout::new(&rig, (640, 360), 16384, read, VertexProcessing::Divided);
            let layout = Arc::new(layout.expect("a plan"));
            let other = layout.of_image((500, 320), Some(part), 16384);
            assert!(
                Arc::ptr_eq(&layout.of_image((500, 320), Some(part), 16384), &other) && other.has_views_of(&layout)
            );
            assert_eq!((other.views.clone(), other.window, other.pixels), (layout.views.clone(), (500, 320), 1.0));
            assert_eq!(other.own().map(|own| (own.width, own.height)), layout.own().map(|_| (500, 320)));
            let twice = layout.of_image((1000, 640), Some(part), 16384);
            assert_eq!((twice.views[0].rect.width, twice.pixels), (2 * layout.views[0].rect.width, 4.0));
        }
    }
}
