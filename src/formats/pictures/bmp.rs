//! Windows bitmaps without compression, with 8 bits, 16 bits or 32-bit floats for each of three or
//! four channels, as in VIOSO's sets: their weights have more bits than other readers of bitmaps
//! accept.

use crate::error::Result;
use crate::formats::reading::bytes::Bytes;
use crate::formats::reading::input::{checked_size, invalid};

/// Length of the headers of every bitmap: of the file, and of the picture.
const HEADERS: usize = 14 + 40;

/// A bitmap.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::formats) struct Bitmap {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Red, green and blue, row by row from the top. Integers become 0…1; floats are clamped to
    /// 0…1.
    pub values: Vec<[f32; 3]>,
}

/// Reads a bitmap whose `bytes` begin with `BM`; `None` for one without pixels. `name` is the
/// file's, for messages.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) with the reason: the picture is cut off,
/// compressed, has a palette, or is too large.
pub(in crate::formats) fn read(name: &str, bytes: &[u8]) -> Result<Option<Bitmap>> {
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
    // A bit mask for each channel, which for 32 bits gives the usual order, is no compression.
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
            // Blue comes first.
            let value = [2, 1, 0].map(|channel: usize| match pixel[channel * bytes_each..][..bytes_each] {
                [value] => f32::from(value) / 255.0,
                [low, high] => f32::from(u16::from_le_bytes([low, high])) / 65535.0,
                [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
                _ => f32::NAN,
            });
            if !value.iter().all(|value| value.is_finite()) {
                return Err(invalid(name, "has a picture with a value that is not finite"));
            }
            values.push(value.map(|value| value.clamp(0.0, 1.0)));
        }
    }
    Ok(Some(Bitmap { size, values }))
}

/// Precision of a bitmap.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(in crate::formats) enum Bits {
    /// 8 bits for each of three channels.
    Eight,
    /// 16 bits for each of three channels.
    Sixteen,
}

/// A bitmap without pixels.
pub(in crate::formats) const EMPTY: [u8; HEADERS] = headers(HEADERS as u32, 0, 0, 24);

/// Headers of a bitmap whose first row is the lowest.
const fn headers(length: u32, width: u32, height: u32, bits: u8) -> [u8; HEADERS] {
    let mut bytes = [0; HEADERS];
    (bytes[0], bytes[1]) = (b'B', b'M');
    let numbers = [(2, length), (10, HEADERS as u32), (14, 40), (18, width), (22, height)];
    let mut index = 0;
    // Constant functions allow no other loop.
    while index < numbers.len() {
        let (at, number) = (numbers[index].0, numbers[index].1.to_le_bytes());
        (bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]) = (number[0], number[1], number[2], number[3]);
        index += 1;
    }
    (bytes[26], bytes[28]) = (1, bits);
    bytes
}

/// Returns a bitmap of these values (0…1, row by row from the top). `name` is that of the map to
/// which it belongs.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) if their number does not fit the size, or is too
/// large for the format.
pub(in crate::formats) fn write(name: &str, size: (u32, u32), values: &[[f32; 3]], bits: Bits) -> Result<Vec<u8>> {
    let (columns, rows) = (size.0 as usize, size.1 as usize);
    let each = if bits == Bits::Eight { 1 } else { 2 };
    let line = (3 * each * columns).next_multiple_of(4);
    let length = u32::try_from(HEADERS + line * rows).ok().filter(|_| columns > 0 && values.len() == columns * rows);
    let length =
        length.ok_or_else(|| invalid(name, "has a picture whose values do not fit its size, or the format"))?;
    let mut bytes = headers(length, size.0, size.1, 24 * each as u8).to_vec();
    for row in values.chunks_exact(columns).rev() {
        let start = bytes.len();
        for value in row.iter().flat_map(|[red, green, blue]| [blue, green, red]) {
            let value = f64::from(value.clamp(0.0, 1.0));
            let written = match bits {
                Bits::Eight => [(value * 255.0).round() as u8; 2],
                Bits::Sixteen => ((value * 65535.0).round() as u16).to_le_bytes(),
            };
            bytes.extend(&written[..each]);
        }
        bytes.resize(start + line, 0);
    }
    Ok(bytes)
}

#[cfg(test)]
pub(in crate::formats) mod tests {
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
                for ([red, green, blue], expected) in found.values.iter().zip(values) {
                    assert!((green - expected).abs() < 1.0 / 255.0, "{bits} {from_top}: {green} {expected}");
                    assert_eq!([*red, *blue], [0.0; 2]);
                }
            }
        }
    }

    #[test]
    fn what_is_written_is_read_back() {
        let values = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0].map(|value| [value, 0.5 * value, 1.0 - value]);
        for (bits, bound) in [(Bits::Eight, 0.5 / 255.0), (Bits::Sixteen, 0.5 / 65535.0)] {
            let bytes = write("a", (3, 2), &values, bits).expect("fits");
            let found = read("a.vwf", &bytes).expect("good").expect("has pixels");
            assert_eq!(found.size, (3, 2));
            let near = |(a, b): (&f32, &f32)| (a - b).abs() <= bound + 1e-7;
            assert!(found.values.as_flattened().iter().zip(values.as_flattened()).all(near), "{found:?}");
        }
        assert_eq!(read("a.vwf", &EMPTY).expect("good"), None);
        assert!(write("a", (4, 2), &values, Bits::Eight).is_err() && write("a", (0, 0), &[], Bits::Eight).is_err());
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
