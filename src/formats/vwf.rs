//! VIOSO's `.vwf`: for each channel a header, four floats for each pixel, and pictures (BMP) of weights.
//!
//! A two-dimensional map has u, v (from the top left), 1 where the pixel shows something, 0; a
//! three-dimensional one the point in metres and 1. Encrypted and compressed maps are refused. The set's
//! pictures after a map are blend, black and white. The blend is read; readers disagree about the others, and only
//! their presence is told, in a note.

use super::bmp::{self, Bitmap};
use super::bytes::Bytes;
use super::grid::Raster;
use super::input::{Noted, checked_size, invalid};
use crate::error::Result;

/// The map's values are points, not positions in a picture.
const POINTS: u32 = 0x40;
const COMPRESSED: u32 = 0x1;
const ENCRYPTED: u32 = 0x400;
/// Length of the oldest header, which every reader knows: 7 numbers, 2 colours, 16 numbers, a name.
const HEADER: u32 = 4 * (7 + 8 + 16) + 256;
/// Longest header of any version, bytes.
const LONGEST_HEADER: u32 = 1 << 16;
/// Greatest number of blocks in a set.
const MOST_BLOCKS: u32 = 1024;

/// A channel of a set.
#[derive(Clone, Debug, PartialEq)]
pub struct VwfMap {
    /// Its name; may be empty.
    pub name: String,
    /// Values are points (metres, in the axes of the program that measured them), not positions in a picture (0…1 from the bottom left).
    pub points: bool,
    /// The values, NaN where nothing is shown.
    pub raster: Raster,
    /// Factors on displayed values, if there are any.
    pub blend: Option<Blend>,
}

/// Factors on the displayed values of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Blend {
    /// Width and height.
    pub size: (u32, u32),
    /// Factors 0…1, row by row from the top.
    pub factors: Vec<f32>,
}

/// Reads all maps of a set. `name` is the file's, for messages.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) with the offset and the reason.
pub fn read(name: &str, bytes: &[u8]) -> Result<Noted<Vec<VwfMap>>> {
    let mut file = Bytes::new(name, bytes);
    if file.array::<4>("the set's header")? != *b"vwf1" {
        return Err(invalid(name, "is no VIOSO file; expected it to begin with vwf1"));
    }
    let blocks = file.u32("the number of blocks")?;
    let start = file.u32("the first block's place")?;
    file.u32("the set's header")?;
    if blocks > MOST_BLOCKS {
        return Err(invalid(name, format!("says that it has {blocks} blocks; expected at most {MOST_BLOCKS}")));
    }
    let skipped = (start as usize).saturating_sub(file.offset());
    file.take(skipped, "the set's header")?;
    let mut maps: Vec<VwfMap> = Vec::new();
    // Of the latest map, and of all; those that are not taken over.
    let (mut of_map, mut pictures, mut left_out) = (0, 0, 0);
    while maps.len() + pictures < blocks as usize && file.left() > 0 {
        let start = file.offset();
        match file.array::<4>("a block")? {
            [b'v', b'w', b'f', b'0'] => {
                maps.push(map(name, &mut file)?);
                of_map = 0;
            }
            [b'B', b'M', low, high] => {
                let rest = file.array::<2>("the length of a picture")?;
                let length = u32::from_le_bytes([low, high, rest[0], rest[1]]) as usize;
                file.take(length.saturating_sub(6), "a picture")?;
                let picture = bmp::read(name, &bytes[start..file.offset()])?;
                match (picture, maps.last_mut()) {
                    (Some(Bitmap { size, values }), Some(map)) if of_map == 0 => {
                        map.blend = Some(Blend { size, factors: values });
                    }
                    (Some(_), _) => left_out += 1,
                    (None, _) => {}
                }
                (of_map, pictures) = (of_map + 1, pictures + 1);
            }
            _ => return Err(file.wrong("neither a map (vwf0) nor a picture (BM) begins before here")),
        }
    }
    if maps.is_empty() {
        return Err(invalid(name, "has no map"));
    }
    let mut notes = Vec::new();
    if left_out > 0 {
        notes.push(format!("{name}: {left_out} pictures of black levels and white were not taken over"));
    }
    Ok(Noted { value: maps, notes })
}

/// A map, after its magic.
fn map(name: &str, file: &mut Bytes) -> Result<VwfMap> {
    let length = file.u32("the header's length")?;
    if !(HEADER..=LONGEST_HEADER).contains(&length) {
        return Err(file.wrong(format!("a header of {length} bytes; expected {HEADER} to {LONGEST_HEADER}")));
    }
    let flags = file.u32("flags")?;
    if flags & (COMPRESSED | ENCRYPTED) != 0 {
        return Err(file.wrong("the map is compressed or encrypted; export it without, or as another format"));
    }
    file.u32("the monitor")?;
    let size = file.u32("the map's length")?;
    let (width, height) = (file.u32("the width")?, file.u32("the height")?);
    let (width, height) = checked_size(name, width.into(), height.into())?;
    let needed = u64::from(width) * u64::from(height) * 16;
    if u64::from(size) != needed {
        return Err(file.wrong(format!("{width} × {height} pixels need {needed} bytes, the header says {size}")));
    }
    file.take(4 * (8 + 16), "colours and settings")?;
    let text = file.array::<256>("the map's name")?;
    let text = &text[..text.iter().position(|byte| *byte == 0).unwrap_or(text.len())];
    file.take((length - HEADER) as usize, "the header")?;
    let points = flags & POINTS != 0;
    let start = file.offset();
    let data = file.take(needed as usize, "the map")?;
    let mut values = Vec::with_capacity(data.len() / 16);
    for (index, pixel) in data.chunks_exact(16).enumerate() {
        let [a, b, c, d] =
            [0, 4, 8, 12].map(|at| f32::from_le_bytes([pixel[at], pixel[at + 1], pixel[at + 2], pixel[at + 3]]));
        let valid = if points { d } else { c };
        // NaN counts as not valid.
        if valid > 0.5 {
            let value = if points { [a, b, c] } else { [a, 1.0 - b, 0.0] };
            if !value.iter().all(|value| value.is_finite()) {
                let at = start + 16 * index;
                return Err(invalid(
                    name,
                    format!("at byte {at}: a pixel that shows something has a value that is not finite"),
                ));
            }
            values.push(value);
        } else {
            values.push([f32::NAN; 3]);
        }
    }
    let raster = Raster::new((width, height), values).ok_or_else(|| invalid(name, "has no pixels"))?;
    Ok(VwfMap { name: String::from_utf8_lossy(text).into_owned(), points, raster, blend: None })
}

/// The bytes of a set with these maps, each with empty pictures.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) if a map is too large for the format.
pub fn write(maps: &[VwfMap]) -> Result<Vec<u8>> {
    let mut bytes = b"vwf1".to_vec();
    for number in [maps.len() as u32, 16, 0] {
        bytes.extend(number.to_le_bytes());
    }
    for map in maps {
        let (width, height) = map.raster.size();
        let size = u32::try_from(map.raster.values().len() * 16)
            .map_err(|_| invalid(&map.name, "the map is too large for a VIOSO file"))?;
        bytes.extend(b"vwf0");
        let flags = if map.points { POINTS } else { 0 };
        for number in [HEADER, flags, 0, size, width, height] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend([1.0f32; 4].iter().chain(&[0.0; 4]).flat_map(|value| value.to_le_bytes()));
        // The picture is not split over several channels: everything is zero.
        bytes.extend([0; 64]);
        let mut name = [0; 256];
        for (to, from) in name.iter_mut().take(255).zip(map.name.bytes()) {
            *to = from;
        }
        bytes.extend(name);
        for [x, y, z] in map.raster.values() {
            let pixel = match (x.is_nan() || y.is_nan() || z.is_nan(), map.points) {
                (true, _) => [0.0; 4],
                (false, true) => [*x, *y, *z, 1.0],
                (false, false) => [*x, 1.0 - y, 1.0, 0.0],
            };
            bytes.extend(pixel.iter().flat_map(|value| value.to_le_bytes()));
        }
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn maps() -> Vec<VwfMap> {
        let values = |i: usize| if i == 2 { [f32::NAN; 3] } else { [i as f32 * 0.125, 0.25, 0.0] };
        let raster = Raster::new((3, 2), (0..6).map(values).collect()).unwrap();
        vec![
            VwfMap { name: "left".into(), points: false, raster: raster.clone(), blend: None },
            VwfMap { name: "right".into(), points: true, raster, blend: None },
        ]
    }

    #[test]
    fn what_is_written_is_read_back() {
        let back = read("a.vwf", &write(&maps()).unwrap()).unwrap().value;
        for (found, expected) in back.iter().zip(&maps()) {
            assert_eq!((&found.name, found.points), (&expected.name, expected.points));
            let pairs = found.raster.values().iter().zip(expected.raster.values());
            assert!(pairs.into_iter().all(|(a, b)| a == b || (a[0].is_nan() && b[0].is_nan())));
        }
    }

    #[test]
    fn the_first_picture_after_a_map_is_its_blend() {
        let values = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];
        let picture = bmp::tests::bitmap(48, false, values);
        let single = write(&maps()[..1]).unwrap();
        let mut bytes = [single.as_slice(), &picture, &picture, &single[16..]].concat();
        bytes[4] = 4;
        let set = read("a.vwf", &bytes).unwrap();
        let blend = set.value[0].blend.as_ref().expect("has a blend");
        assert!(blend.size == (3, 2) && blend.factors.iter().zip(values).all(|(a, b)| (a - b).abs() < 1e-4));
        assert!(set.value.len() == 2 && set.value[1].blend.is_none());
        assert!(set.notes[0].contains("1 pictures of black"), "{:?}", set.notes);
        // Cut off within the picture.
        assert!(read("a.vwf", &bytes[..single.len() + 60]).is_err());
    }

    #[test]
    fn damaged_files_are_refused() {
        let good = write(&maps()).unwrap();
        let refused = |bytes: &[u8], why: &str| {
            let message = read("a.vwf", bytes).unwrap_err().message;
            assert!(message.starts_with("a.vwf") && message.contains(why), "{message}");
        };
        let with = |at: usize, value: u32| {
            let mut bytes = good.clone();
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
            bytes
        };
        refused(b"vwf", "the file ends");
        refused(b"abcdefghijklmnop", "no VIOSO");
        refused(&good[..good.len() - 1], "the file ends");
        refused(&with(24, ENCRYPTED), "encrypted");
        refused(&with(36, 1 << 31), "pixels altogether");
        refused(&with(36, 4), "need 128 bytes");
        refused(&with(4, u32::MAX), "blocks");
        refused(&with(20, 8), "a header of 8 bytes");
        refused(&with(16 + HEADER as usize, 0x7fc0_0000), "not finite");
    }
}
