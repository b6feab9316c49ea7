//! Windows bitmaps without compression, of 8 bits, 16 bits or 32-bit floats for each of three or four channels, as
//! VIOSO's sets have them: weights in more bits than other readers of bitmaps know.

use super::bytes::Bytes;
use super::input::{checked_size, invalid};
use crate::error::Result;

/// Length of the headers that every bitmap has: of the file, and of the picture.
const HEADERS: usize = 14 + 40;

/// The green channel of a bitmap.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bitmap {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Values, 0…1 of the greatest of its bits, row by row from the top; of floats as they are, within 0…1.
    pub values: Vec<f32>,
}

/// Reads a bitmap whose `bytes` begin with `BM`; `None` for one without pixels. `name` is the file's, for messages.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) with the reason: what is cut off, compressed, has a palette, or is too large.
pub(super) fn read(name: &str, bytes: &[u8]) -> Result<Option<Bitmap>> {
    let mut file = Bytes::new(name, bytes);
    file.take(10, "a picture's header")?;
    let start = file.u32("the place of a picture's pixels")? as usize;
    file.u32("a picture's header")?;
    let (width, height) = (file.u32("a picture's width")?, file.u32("a picture's height")?.cast_signed());
    if width == 0 || height == 0 {
        return Ok(None);
    }
    let [_, _, low, high] = file.array::<4>("a picture's bits")?;
    let bits = u16::from_le_bytes([low, high]);
    let compression = file.u32("a picture's compression")?;
    // A mask of bits for each channel, which for 32 bits is the usual order, is no compression.
    if !(compression == 0 || compression == 3 && bits == 32) {
        return Err(invalid(name, "has a compressed picture; expected one without compression"));
    }
    let (size, from_top) = (checked_size(name, width.into(), height.unsigned_abs().into())?, height < 0);
    let (channels, bytes_each) = match bits {
        24 => (3, 1),
        32 => (4, 1),
        48 => (3, 2),
        64 => (4, 2),
        96 => (3, 4),
        128 => (4, 4),
        _ => return Err(invalid(name, format!("has a picture of {bits} bits; expected 24, 32, 48, 64, 96 or 128"))),
    };
    let skipped = start.checked_sub(file.offset()).filter(|_| start >= HEADERS);
    file.take(skipped.ok_or_else(|| invalid(name, "has a picture whose pixels begin in its header"))?, "a header")?;
    let (columns, rows) = (size.0 as usize, size.1 as usize);
    let step = channels * bytes_each;
    let length = (columns * step).next_multiple_of(4);
    let data = file.take(length * rows, "a picture")?;
    let mut values = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        let row = if from_top { row } else { rows - 1 - row };
        for pixel in data[row * length..][..columns * step].chunks_exact(step) {
            let green = &pixel[bytes_each..2 * bytes_each];
            let value = match *green {
                [value] => f32::from(value) / 255.0,
                [low, high] => f32::from(u16::from_le_bytes([low, high])) / 65535.0,
                [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
                _ => f32::NAN,
            };
            if !value.is_finite() {
                return Err(invalid(name, "has a picture with a value that is not finite"));
            }
            values.push(value.clamp(0.0, 1.0));
        }
    }
    Ok(Some(Bitmap { size, values }))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A bitmap of 3 × 2 pixels with these green values from the top left.
    pub fn bitmap(bits: u16, from_top: bool, values: [f32; 6]) -> Vec<u8> {
        let channels = if bits.is_multiple_of(24) { 3 } else { 4 };
        let each = usize::from(bits) / 8 / channels;
        let length = (3 * channels * each).next_multiple_of(4);
        let mut bytes = b"BM".to_vec();
        bytes.extend((HEADERS as u32 + 2 * length as u32).to_le_bytes());
        bytes.extend([0; 4]);
        bytes.extend((HEADERS as u32).to_le_bytes());
        bytes.extend(40u32.to_le_bytes());
        bytes.extend(3u32.to_le_bytes());
        bytes.extend((if from_top { -2i32 } else { 2 }).to_le_bytes());
        bytes.extend(1u16.to_le_bytes());
        bytes.extend(bits.to_le_bytes());
        bytes.extend([0; 24]);
        for row in if from_top { [0, 1] } else { [1, 0] } {
            let before = bytes.len();
            for value in &values[3 * row..3 * row + 3] {
                for channel in 0..channels {
                    let value = if channel == 1 { *value } else { 0.0 };
                    match each {
                        1 => bytes.push((value * 255.0) as u8),
                        2 => bytes.extend(((value * 65535.0) as u16).to_le_bytes()),
                        _ => bytes.extend(value.to_le_bytes()),
                    }
                }
            }
            bytes.resize(before + length, 0);
        }
        bytes
    }

    #[test]
    fn every_number_of_bits_is_read_from_either_side() {
        let values = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];
        for bits in [24, 32, 48, 64, 96, 128] {
            for from_top in [false, true] {
                let found = read("a.vwf", &bitmap(bits, from_top, values)).expect("good").expect("has pixels");
                assert_eq!(found.size, (3, 2));
                for (found, expected) in found.values.iter().zip(values) {
                    assert!((found - expected).abs() < 1.0 / 255.0, "{bits} {from_top}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn damaged_pictures_are_refused() {
        let good = bitmap(48, false, [0.5; 6]);
        let with = |at: usize, value: u32| {
            let mut bytes = good.clone();
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
            bytes
        };
        for end in 0..good.len() {
            assert!(read("a.vwf", &good[..end]).is_err(), "{end}");
        }
        for (bytes, why) in [
            (with(18, u32::MAX), "pixels altogether"),
            (with(22, i32::MIN.cast_unsigned()), "pixels altogether"),
            (with(28, 8), "bits"),
            (with(30, 1), "compressed"),
            (with(10, 3), "in its header"),
            (with(10, u32::MAX), "the file ends"),
        ] {
            let message = read("a.vwf", &bytes).expect_err(why).message;
            assert!(message.contains(why), "{message}");
        }
        assert_eq!(read("a.vwf", &with(18, 0)).expect("empty"), None);
        let mut infinite = bitmap(96, false, [0.5; 6]);
        infinite[HEADERS + 4..HEADERS + 8].copy_from_slice(&f32::INFINITY.to_le_bytes());
        assert!(read("a.vwf", &infinite).is_err());
    }
}
