//! A picture with lines and text.

use crate::failure::Failure;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use std::path::Path;

/// Red, green and blue, 0…1, as written to the file.
pub type Color = [f32; 3];

/// Size of text.
#[derive(Clone, Copy)]
pub enum Letters {
    /// 16 pixels high.
    Small,
    /// 24 pixels high.
    Large,
}

impl Letters {
    fn height(self) -> RasterHeight {
        match self {
            Self::Small => RasterHeight::Size16,
            Self::Large => RasterHeight::Size24,
        }
    }
}

/// Fails if no picture can be written to a file of this name: better before than after the work.
pub fn refuse_other_endings(file: &Path) -> Result<(), Failure> {
    match image::ImageFormat::from_path(file).is_ok_and(|format| format.writing_enabled()) {
        true => Ok(()),
        false => Err(Failure::usage(format!(
            "{}: no picture of this kind can be written; expected a name that ends in .png or .jpg",
            file.display()
        ))),
    }
}

/// A picture in memory.
pub struct Canvas {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// True if text is written from right to left in mirrored letters.
    pub mirrors_text: bool,
    pixels: Vec<Color>,
}

impl Canvas {
    /// A picture of one colour.
    pub fn new(width: usize, height: usize, color: Color) -> Self {
        Self { width, height, mirrors_text: false, pixels: vec![color; width * height] }
    }

    /// Blends a colour over a pixel with opacity `part` (0…1). Does nothing outside the picture.
    pub fn blend(&mut self, x: i64, y: i64, color: Color, part: f32) {
        if x < 0 || y < 0 || x as usize >= self.width || y as usize >= self.height {
            return;
        }
        for (old, new) in self.pixels[y as usize * self.width + x as usize].iter_mut().zip(color) {
            *old += part * (new - *old);
        }
    }

    /// The colour of a pixel inside the picture.
    #[cfg(test)]
    pub fn at(&self, x: usize, y: usize) -> Color {
        self.pixels[y * self.width + x]
    }

    /// Gives each pixel the colour of its column and row.
    pub fn fill(&mut self, color: impl Fn(usize, usize) -> Color) {
        let width = self.width;
        for (index, pixel) in self.pixels.iter_mut().enumerate() {
            *pixel = color(index % width, index / width);
        }
    }

    /// Fills a rectangle, as far as it is inside the picture.
    pub fn rectangle(&mut self, (x, y): (u32, u32), (width, height): (u32, u32), color: Color) {
        let columns = (x as usize).min(self.width)..((x + width) as usize).min(self.width);
        for row in (y as usize).min(self.height)..((y + height) as usize).min(self.height) {
            self.pixels[row * self.width..][columns.clone()].fill(color);
        }
    }

    /// Copies another picture to a place, as far as it is inside this one.
    pub fn paste(&mut self, other: &Self, x: usize, y: usize) {
        let width = other.width.min(self.width.saturating_sub(x));
        for row in 0..other.height.min(self.height.saturating_sub(y)) {
            let from = &other.pixels[row * other.width..][..width];
            self.pixels[(y + row) * self.width + x..][..width].copy_from_slice(from);
        }
    }

    /// Draws an antialiased line between two points in pixels.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], width: f64, color: Color) {
        let (along, half) = ([to[0] - from[0], to[1] - from[1]], 0.5 * width);
        let squared = along[0] * along[0] + along[1] * along[1];
        let range = |axis: usize| {
            ((from[axis].min(to[axis]) - half - 1.0) as i64, (from[axis].max(to[axis]) + half + 1.0) as i64)
        };
        let ((left, right), (top, bottom)) = (range(0), range(1));
        for (y, x) in (top..=bottom).flat_map(|y| (left..=right).map(move |x| (y, x))) {
            let offset = [x as f64 + 0.5 - from[0], y as f64 + 0.5 - from[1]];
            let part = (offset[0] * along[0] + offset[1] * along[1]) / squared.max(1e-12);
            let part = part.clamp(0.0, 1.0);
            let distance = (offset[0] - part * along[0]).hypot(offset[1] - part * along[1]);
            self.blend(x, y, color, (half + 0.5 - distance).clamp(0.0, 1.0) as f32);
        }
    }

    /// Draws text with its upper left corner at (x, y). Characters that the font lacks are left
    /// out.
    pub fn text(&mut self, text: &str, x: i64, y: i64, letters: Letters, color: Color) {
        let advance = get_raster_width(FontWeight::Regular, letters.height()) as i64;
        let last = x + text.chars().count() as i64 * advance - 1;
        for (letter, left) in text.chars().zip((0..).map(|index| x + index * advance)) {
            let Some(glyph) = get_raster(letter, FontWeight::Regular, letters.height()) else { continue };
            for (row, line) in (0..).zip(glyph.rows()) {
                for (column, cover) in (0..).zip(line) {
                    let across = if self.mirrors_text { last - (left - x + column) } else { left + column };
                    self.blend(across, y + row, color, f32::from(*cover) / 255.0);
                }
            }
        }
    }

    /// Draws text around a centre, with a shadow so that it can be read on any background.
    pub fn label(&mut self, text: &str, centre: [f64; 2], color: Color) {
        self.heading(text, centre, Letters::Small, color);
    }

    /// The same in letters of any size.
    pub fn heading(&mut self, text: &str, centre: [f64; 2], letters: Letters, color: Color) {
        let width = text.chars().count() * get_raster_width(FontWeight::Regular, letters.height());
        let (x, y) = (centre[0] as i64 - width as i64 / 2, centre[1] as i64 - letters.height().val() as i64 / 2);
        for (across, down) in [(-1, 0), (1, 0), (0, -1), (0, 1), (1, 1), (2, 1)] {
            self.text(text, x + across, y + down, letters, [0.02, 0.02, 0.04]);
        }
        self.text(text, x, y, letters, color);
    }

    /// The picture with 8 bits per channel, row by row from the top.
    pub fn bytes(&self) -> Vec<u8> {
        self.pixels.iter().flatten().map(|value| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8).collect()
    }
}
