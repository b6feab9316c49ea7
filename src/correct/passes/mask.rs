//! Weight images: reading, and which pixels they leave black or white.

use crate::error::Result;
use crate::geom::rectangle::{PixelRect, PixelSpan};
use crate::rig::{Flip, read_mask};
use std::path::Path;

/// A weight image.
#[derive(Clone, Debug, PartialEq)]
pub struct Mask {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Weights, 16 bit, row by row from the top.
    pub weights: Vec<u16>,
}

/// Reads a weight image; its values are linear weights.
///
/// # Errors
/// Those of [`read_mask`], which name the path.
pub fn load(path: &Path) -> Result<Mask> {
    let ((width, height), weights) = read_mask(path)?;
    Ok(Mask { width, height, weights })
}

impl Mask {
    /// Returns a mask for a picture of `size` pixels: 0 for pixels that are not `lit`, otherwise the
    /// weight of `weights`, which is stretched over the picture.
    pub(in crate::correct) fn of_pixels(lit: &[bool], size: (u32, u32), weights: Option<&Self>) -> Self {
        let weight = |index: u32| weights.map_or(u16::MAX, |mask| mask.weight(index % size.0, index / size.0, size));
        let weights = (0..).zip(lit).map(|(index, lit)| if *lit { weight(index) } else { 0 }).collect();
        Self { width: size.0, height: size.1, weights }
    }

    /// Weight in the middle of a pixel of a picture over which the mask is stretched.
    fn weight(&self, x: u32, y: u32, size: (u32, u32)) -> u16 {
        let place = |pixel: u32, pixels: u32, texels: u32| {
            let at = (f64::from(pixel) + 0.5) * f64::from(texels) / f64::from(pixels) - 0.5;
            let low = at.floor().clamp(0.0, f64::from(texels - 1));
            (low as u32, (low as u32 + 1).min(texels - 1), (at - low).clamp(0.0, 1.0))
        };
        let ((left, right, u), (top, bottom, v)) = (place(x, size.0, self.width), place(y, size.1, self.height));
        let at = |column: u32, row: u32| f64::from(self.weights[(row * self.width + column) as usize]);
        let along = |row: u32| at(left, row) * (1.0 - u) + at(right, row) * u;
        (along(top) * (1.0 - v) + along(bottom) * v).round() as u16
    }

    /// Returns the mask of the mirrored picture.
    pub(in crate::correct) fn flipped(self, flip: Flip) -> Self {
        Self { weights: flip.items(&self.weights, self.width as usize), ..self }
    }

    /// True if the weight is 0 everywhere in a block of an output of `size` pixels, over which
    /// the mask is stretched with bilinear filtering.
    pub fn is_black(&self, block: PixelSpan, size: (u32, u32)) -> bool {
        self.is_all(0, block, size)
    }

    /// True if the weight is 1 everywhere in a block, as for [`Mask::is_black`].
    pub fn is_white(&self, block: PixelSpan, size: (u32, u32)) -> bool {
        self.is_all(u16::MAX, block, size)
    }

    /// Returns `rect` without rows and columns at its borders that are black as for
    /// [`Mask::is_black`]. At least one pixel remains.
    pub(in crate::correct) fn trimmed(&self, rect: PixelRect, size: (u32, u32)) -> PixelRect {
        let [mut left, mut top, mut right, mut bottom] = [rect.x, rect.y, rect.x + rect.width, rect.y + rect.height];
        while right - left > 1 && self.is_black(PixelSpan::new(left, top, left + 1, bottom), size) {
            left += 1;
        }
        while right - left > 1 && self.is_black(PixelSpan::new(right - 1, top, right, bottom), size) {
            right -= 1;
        }
        while bottom - top > 1 && self.is_black(PixelSpan::new(left, top, right, top + 1), size) {
            top += 1;
        }
        while bottom - top > 1 && self.is_black(PixelSpan::new(left, bottom - 1, right, bottom), size) {
            bottom -= 1;
        }
        PixelRect { x: left, y: top, width: right - left, height: bottom - top }
    }

    fn is_all(&self, value: u16, block: PixelSpan, size: (u32, u32)) -> bool {
        // The filter reads the texels from the one before that of the low edge to the one after
        // that of the high edge, and no others.
        let range = |low: u32, high: u32, pixels: u32, texels: u32| {
            let at = |pixel: u32| u64::from(pixel) * u64::from(texels) / u64::from(pixels.max(1));
            let end = (at(high) + 2).min(u64::from(texels));
            at(low).saturating_sub(1) as usize..end as usize
        };
        let (columns, rows) =
            (range(block.left, block.right, size.0, self.width), range(block.top, block.bottom, size.1, self.height));
        rows.into_iter().all(|row| {
            let start = row * self.width as usize;
            let line = self.weights.get(start + columns.start..start + columns.end);
            line.is_some_and(|weights| weights.iter().all(|weight| *weight == value))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_black_only_where_the_filter_reads_nothing_else() {
        let lit = |x: u32, y: u32| u16::from(x == 10 && y == 7);
        let weights = (0..12).flat_map(|y| (0..20).map(move |x| lit(x, y))).collect();
        let mask = Mask { width: 20, height: 12, weights };
        for size in [(20, 12), (40, 24), (333, 100), (7, 5), (1, 1)] {
            // Bilinear weights of the texel at every pixel, centres and borders alike.
            let touched = |x: f64, texels: u32, pixels: u32, texel: f64| {
                (x * f64::from(texels) / f64::from(pixels) - 0.5 - texel).abs() < 1.0
            };
            for (y, x) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (y, x))) {
                let sees = [0.0, 0.5, 1.0].iter().any(|u| touched(f64::from(x) + u, 20, size.0, 10.0))
                    && [0.0, 0.5, 1.0].iter().any(|v| touched(f64::from(y) + v, 12, size.1, 7.0));
                let black = mask.is_black(PixelSpan::new(x, y, x + 1, y + 1), size);
                assert!(!(sees && black), "pixel {x}, {y} of {size:?}");
            }
        }
        let white = Mask { weights: mask.weights.iter().map(|weight| u16::MAX - weight).collect(), ..mask.clone() };
        assert!(!white.is_white(PixelSpan::new(8, 5, 12, 9), (20, 12)), "one texel in the block is not white");
        let white = Mask { weights: vec![u16::MAX; 240], ..white };
        assert!(
            white.is_white(PixelSpan::new(0, 0, 20, 12), (20, 12))
                && !white.is_black(PixelSpan::new(0, 0, 1, 1), (20, 12))
        );
        assert!(
            mask.is_black(PixelSpan::new(0, 0, 8, 12), (20, 12))
                && !mask.is_black(PixelSpan::new(0, 0, 12, 12), (20, 12))
        );
    }

    #[test]
    fn pixels_without_light_are_black_in_a_stretched_mask() {
        let mask = Mask { width: 2, height: 1, weights: vec![0, 40_000] };
        let lit: Vec<bool> = (0..8).map(|index| index != 6).collect();
        let pixels = Mask::of_pixels(&lit, (4, 2), Some(&mask));
        assert_eq!(pixels.weights, [0, 10_000, 30_000, 40_000, 0, 10_000, 0, 40_000]);
        assert_eq!(Mask::of_pixels(&lit, (4, 2), None).weights[5..], [u16::MAX, 0, u16::MAX]);
    }

    #[test]
    fn rectangles_end_where_the_mask_does() {
        // White in columns 3 to 5 and rows 2 to 9 of 12 × 12 texels, over 24 × 24 pixels.
        let white = |x: u32, y: u32| (3..6).contains(&x) && (2..10).contains(&y);
        let weights = (0..144).map(|i| if white(i % 12, i / 12) { u16::MAX } else { 0 }).collect();
        let mask = Mask { width: 12, height: 12, weights };
        let rect = |x, y, width, height| PixelRect { x, y, width, height };
        let whole = mask.trimmed(rect(0, 0, 24, 24), (24, 24));
        assert!(
            whole.x >= 3 && whole.x + whole.width <= 15 && whole.y >= 1 && whole.y + whole.height <= 23,
            "{whole:?}"
        );
        // Only black pixels are cut off, whatever the rectangle.
        for (x, y, width, height) in [(0, 0, 24, 24), (7, 5, 16, 2), (0, 0, 5, 24), (20, 20, 4, 4), (9, 9, 1, 1)] {
            let kept = mask.trimmed(rect(x, y, width, height), (24, 24));
            for (column, row) in (y..y + height).flat_map(|row| (x..x + width).map(move |column| (column, row))) {
                let inside =
                    (kept.x..kept.x + kept.width).contains(&column) && (kept.y..kept.y + kept.height).contains(&row);
                assert!(
                    inside || mask.is_black(PixelSpan::new(column, row, column + 1, row + 1), (24, 24)),
                    "{column}, {row}"
                );
            }
        }
    }

    use crate::error::ErrorKind;
    use image::{DynamicImage, GrayImage, ImageBuffer, Luma, Rgb, RgbImage};

    /// Saves `picture` under a name of its own, loads it, and removes it.
    fn reloaded(name: &str, picture: DynamicImage) -> Mask {
        let path = std::env::temp_dir().join(format!("cupola-mask-{}-{name}.png", std::process::id()));
        picture.save(&path).unwrap();
        let mask = load(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        mask
    }

    #[test]
    fn reads_grey_of_8_and_16_bits_and_the_luma_of_colour() {
        let eight = GrayImage::from_fn(3, 2, |x, y| Luma([(100 * x + 20 * y) as u8]));
        let mask = reloaded("8", eight.into());
        assert_eq!((mask.width, mask.height), (3, 2));
        assert_eq!(mask.weights, [0, 100, 200, 20, 120, 220].map(|value: u16| value * 257));

        let sixteen = ImageBuffer::from_fn(2, 2, |x, y| Luma([(1 + 1000 * x + 30000 * y) as u16]));
        assert_eq!(reloaded("16", sixteen.into()).weights, [1, 1001, 30001, 31001]);

        let colour = RgbImage::from_fn(2, 1, |x, _| if x == 0 { Rgb([255; 3]) } else { Rgb([0, 255, 0]) });
        let weights = reloaded("colour", colour.into()).weights;
        assert_eq!(weights[0], 65535);
        assert!((30000..60000).contains(&weights[1]), "green is bright, but not white: {}", weights[1]);
    }

    #[test]
    fn names_the_path_of_what_it_cannot_read() {
        let missing = load(Path::new("no/such/mask.png")).unwrap_err();
        assert_eq!(missing.kind, ErrorKind::Io);
        assert!(missing.message.contains("no/such/mask.png"));

        let path = std::env::temp_dir().join(format!("cupola-mask-{}-text.png", std::process::id()));
        std::fs::write(&path, "not a picture").unwrap();
        let wrong = load(&path).unwrap_err();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(wrong.kind, ErrorKind::InvalidRig);
        assert!(wrong.message.contains(&*path.to_string_lossy()));
    }
}
