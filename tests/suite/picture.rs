//! Pictures of 8-bit RGB: reading, writing, differences.

use std::path::Path;

/// A picture. Row 0 is at the top.
#[derive(Clone, PartialEq, Eq)]
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// Makes a picture whose pixels are `colour` of column and row.
    pub fn from_fn(width: usize, height: usize, mut colour: impl FnMut(usize, usize) -> [u8; 3]) -> Self {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| colour(x, y)).collect();
        Self { width, height, pixels }
    }

    /// Pixel in column `x` and row `y`.
    pub fn at(&self, x: usize, y: usize) -> [u8; 3] {
        self.pixels[y * self.width + x]
    }

    /// Reads a PNG or binary PPM file. Panics with the file's name if that fails.
    pub fn load(path: &Path) -> Self {
        if path.extension().is_some_and(|extension| extension == "ppm") {
            return Self::load_ppm(path);
        }
        let image = image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).to_rgb8();
        let (width, height) = (image.width() as usize, image.height() as usize);
        Self { width, height, pixels: image.pixels().map(|pixel| pixel.0).collect() }
    }

    fn load_ppm(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut lines = bytes.splitn(4, |byte| *byte == b'\n');
        let [magic, size, _, data] = [(); 4].map(|()| lines.next().unwrap_or_default());
        assert_eq!(magic, b"P6", "{} is not a binary PPM", path.display());
        let size = std::str::from_utf8(size).expect("a PPM's size is text");
        let (width, height) = size.split_once(' ').expect("a PPM's size has two numbers");
        let (width, height) = (width.parse().expect("width"), height.parse().expect("height"));
        assert_eq!(data.len(), 3 * width * height, "{} is cut off", path.display());
        Self { width, height, pixels: data.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect() }
    }

    /// Writes a PNG file.
    pub fn save(&self, path: &Path) {
        let bytes: Vec<u8> = self.pixels.iter().flatten().copied().collect();
        image::save_buffer(path, &bytes, self.width as u32, self.height as u32, image::ColorType::Rgb8)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }

    /// Number of pixels that differ, and the greatest difference of a channel. Panics if the sizes
    /// differ.
    pub fn difference(&self, other: &Self) -> (usize, u8) {
        assert_eq!((self.width, self.height), (other.width, other.height), "the pictures' sizes differ");
        let differences = self
            .pixels
            .iter()
            .zip(&other.pixels)
            .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0));
        differences.fold((0, 0), |(count, worst), step| (count + usize::from(step > 0), worst.max(step)))
    }
}
