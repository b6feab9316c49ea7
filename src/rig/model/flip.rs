//! Mirrored pictures: for projectors behind a screen, before a flat mirror, or mounted upside down.

use glam::DVec2;

/// Mirroring of the finished picture of an output, with everything in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Flip {
    /// Left and right are exchanged.
    pub horizontal: bool,
    /// Top and bottom are exchanged.
    pub vertical: bool,
}

impl Flip {
    /// True if nothing is exchanged.
    pub fn is_none(self) -> bool {
        self == Self::default()
    }

    /// Words of the rig file.
    pub const WORDS: [(&'static str, Self); 4] = [
        ("none", Self { horizontal: false, vertical: false }),
        ("horizontal", Self { horizontal: true, vertical: false }),
        ("vertical", Self { horizontal: false, vertical: true }),
        ("both", Self { horizontal: true, vertical: true }),
    ];

    /// Word in the rig file.
    pub fn word(self) -> &'static str {
        Self::WORDS.iter().find(|(_, flip)| *flip == self).map_or("none", |(word, _)| word)
    }

    /// Returns −1 along mirrored axes, 1 along others.
    pub fn signs(self) -> DVec2 {
        let sign = |turned: bool| if turned { -1.0 } else { 1.0 };
        DVec2::new(sign(self.horizontal), sign(self.vertical))
    }

    /// Returns the mirrored place of a pixel position (from the top left) in a picture of `size`
    /// pixels. Mirroring it again gives the old position.
    pub fn pixel(self, pixel: DVec2, size: (u32, u32)) -> DVec2 {
        let (width, height) = (f64::from(size.0), f64::from(size.1));
        DVec2::new(
            if self.horizontal { width - pixel.x } else { pixel.x },
            if self.vertical { height - pixel.y } else { pixel.y },
        )
    }

    /// Mirrors the items of a picture, row by row, `width` in each.
    pub fn items<T: Clone>(self, items: &[T], width: usize) -> Vec<T> {
        let mut rows: Vec<&[T]> = items.chunks(width.max(1)).collect();
        if self.vertical {
            rows.reverse();
        }
        let row = |row: &[T]| if self.horizontal { row.iter().rev().cloned().collect() } else { row.to_vec() };
        rows.into_iter().flat_map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twice_is_not_at_all() {
        let picture = [1, 2, 3, 4, 5, 6];
        let flip = |horizontal, vertical| Flip { horizontal, vertical };
        assert_eq!(flip(true, false).items(&picture, 3), [3, 2, 1, 6, 5, 4]);
        assert_eq!(flip(false, true).items(&picture, 3), [4, 5, 6, 1, 2, 3]);
        assert_eq!(flip(true, true).items(&picture, 3), [6, 5, 4, 3, 2, 1]);
        for flip in [flip(false, false), flip(true, false), flip(false, true), flip(true, true)] {
            assert_eq!(flip.items(&flip.items(&picture, 3), 3), picture);
            let pixel = DVec2::new(0.5, 1.25);
            assert_eq!(flip.pixel(flip.pixel(pixel, (3, 2)), (3, 2)), pixel);
            let middle = DVec2::new(1.5, 1.0);
            assert_eq!(flip.pixel(pixel, (3, 2)) - middle, flip.signs() * (pixel - middle));
        }
    }
}
