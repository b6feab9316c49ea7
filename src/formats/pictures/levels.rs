//! Pictures that a display shows where a program shows black.

use crate::digest::Digest;
use crate::error::{Error, ErrorKind, Result};
use crate::formats::pictures::pfm;
use crate::formats::reading::input;
use crate::formats::reading::input::invalid;
use glam::DVec2;
use serde::{Serialize, Serializer};
use std::fmt;

/// Values for each channel of each pixel, 0…1; their owner defines their meaning.
#[derive(Clone, PartialEq)]
pub struct Levels {
    /// Width and height.
    pub size: (u32, u32),
    /// Red, green and blue, row by row from the top.
    pub values: Vec<[f32; 3]>,
}

impl Levels {
    fn sum(&self) -> Digest {
        self.values.iter().flatten().map(|value| f64::from(*value)).collect()
    }
}

/// As in [`Debug`](fmt::Debug), a checksum replaces the values.
impl Serialize for Levels {
    fn serialize<S: Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        (self.size, self.sum()).serialize(to)
    }
}

/// The text has a checksum of all bits of the values.
impl fmt::Debug for Levels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sum = format_args!("{:x}", self.sum());
        f.debug_struct("Levels").field("size", &self.size).field("sum", &sum).finish()
    }
}

/// Reads a PNG of 8 or 16 bits or a PFM, grey or colour. `name` is the file's, for messages.
///
/// # Errors
/// [`ErrorKind::InvalidRig`] with the reason: a file of another kind, or a value outside 0…1, with
/// its pixel.
pub fn read(name: &str, bytes: &[u8]) -> Result<Levels> {
    if !pfm::is_pfm(bytes) {
        return read_png(name, bytes);
    }
    let raster = pfm::read(name, bytes)?;
    let wrong = |value: &[f32; 3]| value.iter().any(|value| !(0.0..=1.0).contains(value));
    if let Some(at) = raster.values().iter().position(wrong) {
        let (column, row) = (at % raster.size().0 as usize, at / raster.size().0 as usize);
        let [red, green, blue] = raster.values()[at];
        return Err(invalid(
            name,
            format!("has ({red}, {green}, {blue}) at column {column}, row {row}; expected values from 0 to 1"),
        ));
    }
    Ok(Levels { size: raster.size(), values: raster.values().to_vec() })
}

/// Reads a PNG of 8 or 16 bits, grey or colour; transparency is ignored.
///
/// # Errors
/// [`ErrorKind::InvalidRig`] with the reason.
pub fn read_png(name: &str, bytes: &[u8]) -> Result<Levels> {
    let picture = input::png(name, bytes)?.into_rgb16();
    let values = picture.pixels().map(|pixel| pixel.0.map(|value| f32::from(value) / 65535.0));
    Ok(Levels { size: picture.dimensions(), values: values.collect() })
}

impl Levels {
    /// Makes levels with the same value everywhere.
    pub fn even(size: (u32, u32), level: f32) -> Self {
        Self { size, values: vec![[level; 3]; size.0 as usize * size.1 as usize] }
    }

    /// True if all channels are equal.
    pub fn is_grey(&self) -> bool {
        self.values.iter().all(|[red, green, blue]| red == green && green == blue)
    }

    /// The least and the greatest value.
    pub fn range(&self) -> (f32, f32) {
        let values = self.values.as_flattened().iter();
        values.fold((f32::INFINITY, 0.0f32), |(low, high), value| (low.min(*value), high.max(*value)))
    }

    /// Values at a place (0…1 from the top left), interpolated between the centres of pixels as in
    /// textures.
    pub fn at(&self, part: DVec2) -> [f64; 3] {
        let place = part * DVec2::new(f64::from(self.size.0), f64::from(self.size.1)) - 0.5;
        let (first, part) = (place.floor(), place - place.floor());
        let index = |at: f64, count: u32| at.clamp(0.0, f64::from(count.saturating_sub(1))) as usize;
        let value = |x: f64, y: f64, channel: usize| {
            let pixel = index(first.y + y, self.size.1) * self.size.0 as usize + index(first.x + x, self.size.0);
            self.values.get(pixel).map_or(0.0, |value| f64::from(value[channel]))
        };
        std::array::from_fn(|channel| {
            let row = |y: f64| value(0.0, y, channel) * (1.0 - part.x) + value(1.0, y, channel) * part.x;
            row(0.0) * (1.0 - part.y) + row(1.0) * part.y
        })
    }

    /// The same levels with another number of pixels.
    pub fn resized(&self, size: (u32, u32)) -> Self {
        if size == self.size {
            return self.clone();
        }
        let extent = DVec2::new(f64::from(size.0), f64::from(size.1));
        let places = (0..size.1).flat_map(|y| (0..size.0).map(move |x| DVec2::new(f64::from(x), f64::from(y)) + 0.5));
        Self { size, values: places.map(|place| self.at(place / extent).map(|value| value as f32)).collect() }
    }

    /// Encodes them as a PNG of 16 bits, grey if all channels are equal.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidRig`] if the number of values does not fit the size,
    /// [`ErrorKind::Internal`] if packing fails.
    pub fn png(&self, name: &str) -> Result<Vec<u8>> {
        let code = |value: &f32| (value.clamp(0.0, 1.0) * 65535.0).round() as u16;
        let (width, height) = self.size;
        let picture = if self.is_grey() {
            let values = self.values.iter().map(|value| code(&value[0])).collect();
            image::ImageBuffer::<image::Luma<u16>, Vec<u16>>::from_raw(width, height, values).map(Into::into)
        } else {
            let values = self.values.as_flattened().iter().map(code).collect();
            image::ImageBuffer::<image::Rgb<u16>, Vec<u16>>::from_raw(width, height, values).map(Into::into)
        };
        let picture: image::DynamicImage =
            picture.ok_or_else(|| invalid(name, "has a picture whose values do not fit its size"))?;
        let mut bytes = std::io::Cursor::new(Vec::new());
        let written = picture.write_to(&mut bytes, image::ImageFormat::Png);
        written.map_err(|error| Error::new(ErrorKind::Internal, format!("{name}: packing a picture: {error}")))?;
        Ok(bytes.into_inner())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_read_back_grey_or_in_colour() {
        let levels = |values: Vec<[f32; 3]>| Levels { size: (2, 1), values };
        for written in [levels(vec![[0.0; 3], [0.125; 3]]), levels(vec![[0.0, 0.5, 1.0], [0.1, 0.2, 0.3]])] {
            let found = read("a.png", &written.png("a.png").expect("fits")).expect("good");
            let near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-5;
            assert!(found.values.as_flattened().iter().zip(written.values.as_flattened()).all(near), "{found:?}");
            let raster = pfm::write(2, &written.values);
            assert_eq!(read("a.pfm", &raster).expect("good"), written);
        }
        assert!(levels(vec![[0.0; 3]]).png("a").is_err());
    }

    #[test]
    fn what_lies_between_pixels_is_interpolated() {
        let levels = Levels { size: (2, 2), values: vec![[0.0; 3], [1.0; 3], [0.5; 3], [0.5, 0.0, 1.0]] };
        let at = |x, y| levels.at(DVec2::new(x, y));
        assert_eq!(at(0.75, 0.25), [1.0; 3]);
        assert_eq!(at(1.0, 0.0), [1.0; 3], "clamped");
        assert_eq!(at(0.5, 0.25), [0.5; 3]);
        assert_eq!(at(0.75, 0.5), [0.75, 0.5, 1.0]);
        assert_eq!((levels.range(), levels.is_grey()), ((0.0, 1.0), false));
        assert_eq!(levels.resized((1, 1)).values, [[0.5, 0.375, 0.625]]);
        assert_eq!(Levels::even((3, 1), 0.25).resized((2, 2)), Levels::even((2, 2), 0.25));
    }

    #[test]
    fn what_is_no_level_is_refused_with_its_pixel() {
        for (bad, words) in [(f32::NAN, "NaN"), (-0.01, "-0.01"), (1.5, "1.5")] {
            let file = pfm::write(2, &[[0.0; 3], [0.1; 3], [0.2; 3], [0.1, bad, 0.1]]);
            let message = read("a.pfm", &file).expect_err(words).message;
            assert!(message.contains("column 1, row 1") && message.contains(words), "{message}");
        }
        assert!(read("a.png", b"not a picture").expect_err("no picture").message.starts_with("a.png: is no PNG"));
    }
}
