//! VIOSO's `.vwf`: for each channel a header, four floats for each pixel, and pictures of weights
//! (BMP).
//!
//! A two-dimensional map has u, v (from the top left), 1 where the pixel shows something, 0. A
//! three-dimensional map has the point in metres and 1. Encrypted and compressed maps are refused.
//! The set's pictures after a map are blend, black and white. Readers differ in their use of black,
//! but all add the same to black as long as the header's other settings for it are 0…1.

use super::grid::Raster;
use crate::error::Result;
use crate::formats::pictures::bmp;
use crate::formats::pictures::bmp::Bitmap;
use crate::formats::pictures::levels::Levels;
use crate::formats::reading::bytes::Bytes;
use crate::formats::reading::input::{Noted, checked_size, invalid};

/// Flag: the map's values are points, not positions in a picture.
const POINTS: u32 = 0x40;
const COMPRESSED: u32 = 0x1;
/// Flag: there is a black picture.
const BLACK_LEVEL: u32 = 0x20;
/// Flag: the blend has 16 bits.
const BLEND_OF_16_BITS: u32 = 0x100;
/// Index of the black picture's factor among the 16 settings.
const BLACK_SCALE: usize = 9;
const ENCRYPTED: u32 = 0x400;
/// Length of the oldest header, which every reader accepts: 7 numbers, 2 colours, 16 numbers, a
/// name.
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
    /// True if values are points (metres, in the axes of the program that measured them), false if
    /// they are positions in a picture (0…1 from the bottom left).
    pub points: bool,
    /// Values, NaN where nothing is shown.
    pub raster: Raster,
    /// Factors on displayed values, if there are any.
    pub blend: Option<Picture>,
    /// Displayed values to which black is raised, if there are any.
    pub black: Option<Levels>,
    /// More factors on displayed values, if there are any.
    pub white: Option<Picture>,
}

/// Displayed values of a channel, or factors on them.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height.
    pub size: (u32, u32),
    /// Values 0…1, row by row from the top.
    pub values: Vec<f32>,
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
    // Pictures of the latest map, of all maps, and pictures of unknown meaning.
    let (mut of_map, mut pictures, mut left_out) = (0, 0, 0);
    let mut scale = 1.0;
    while maps.len() + pictures < blocks as usize && file.left() > 0 {
        let start = file.offset();
        match file.array::<4>("a block")? {
            [b'v', b'w', b'f', b'0'] => {
                let (map, black_scale) = map(name, &mut file)?;
                maps.push(map);
                (of_map, scale) = (0, black_scale);
            }
            [b'B', b'M', low, high] => {
                let rest = file.array::<2>("the length of a picture")?;
                let length = u32::from_le_bytes([low, high, rest[0], rest[1]]) as usize;
                file.take(length.saturating_sub(6), "a picture")?;
                let picture = bmp::read(name, &bytes[start..file.offset()])?;
                match (maps.last_mut(), of_map) {
                    (Some(map), 0) => map.blend = picture.map(Picture::of),
                    (Some(map), 1) => map.black = picture.map(|picture| scaled(picture, scale)),
                    (Some(map), 2) => map.white = picture.map(Picture::of),
                    _ => left_out += usize::from(picture.is_some()),
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
        notes.push(format!(
            "{name}: {left_out} pictures are more than blend, black and white of a map, and were not taken over"
        ));
    }
    Ok(Noted { value: maps, notes })
}

impl Picture {
    /// Takes the green channel.
    fn of(Bitmap { size, values }: Bitmap) -> Self {
        Self { size, values: values.iter().map(|value| value[1]).collect() }
    }

    /// Gives all channels the same values.
    fn grey(&self) -> Levels {
        Levels { size: self.size, values: self.values.iter().map(|value| [*value; 3]).collect() }
    }
}

fn scaled(Bitmap { size, values }: Bitmap, scale: f32) -> Levels {
    Levels { size, values: values.iter().map(|value| value.map(|value| (value * scale).clamp(0.0, 1.0))).collect() }
}

/// Reads a map, after its magic, and the factor on its black picture.
fn map(name: &str, file: &mut Bytes) -> Result<(VwfMap, f32)> {
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
    file.take(4 * (8 + BLACK_SCALE), "colours and settings")?;
    let scale = f32::from_le_bytes(file.array("settings")?);
    // Writers without a black picture leave 0 there.
    let scale = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
    file.take(4 * (15 - BLACK_SCALE), "settings")?;
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
        // NaN counts as invalid.
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
    let name = String::from_utf8_lossy(text).into_owned();
    Ok((VwfMap { name, points, raster, blend: None, black: None, white: None }, scale))
}

/// Returns the bytes of a set with these maps and their pictures (16 bits; 8 bits for black, as
/// readers expect).
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) if a map is too large for the format, or the number
/// of values of a picture does not fit its size.
pub fn write(maps: &[VwfMap]) -> Result<Vec<u8>> {
    let mut bytes = b"vwf1".to_vec();
    let pictures = maps.iter().map(|map| map.pictures().len());
    for number in [maps.len() as u32 + pictures.sum::<usize>() as u32, 16, 0] {
        bytes.extend(number.to_le_bytes());
    }
    for map in maps {
        let (width, height) = map.raster.size();
        let size = u32::try_from(map.raster.values().len() * 16)
            .map_err(|_| invalid(&map.name, "the map is too large for a VIOSO file"))?;
        bytes.extend(b"vwf0");
        let blend = if map.blend.is_some() { BLEND_OF_16_BITS } else { 0 };
        let black = if map.black.is_some() { BLACK_LEVEL } else { 0 };
        let flags = if map.points { POINTS } else { 0 } | blend | black;
        for number in [HEADER, flags, 0, size, width, height] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend([1.0f32; 4].iter().chain(&[0.0; 4]).flat_map(|value| value.to_le_bytes()));
        // The picture is not split over several channels: only the factor of black is not zero.
        let mut settings = [0.0f32; 16];
        settings[BLACK_SCALE] = if map.black.is_some() { 1.0 } else { 0.0 };
        bytes.extend(settings.iter().flat_map(|value| value.to_le_bytes()));
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
        for (number, picture) in map.pictures().into_iter().enumerate() {
            let bits = if number == 1 { bmp::Bits::Eight } else { bmp::Bits::Sixteen };
            bytes.extend(match picture {
                Some(Levels { size, values }) => bmp::write(&map.name, size, &values, bits)?,
                None => bmp::EMPTY.to_vec(),
            });
        }
    }
    Ok(bytes)
}

impl VwfMap {
    /// Pictures in the order of the file, up to the last that exists.
    fn pictures(&self) -> Vec<Option<Levels>> {
        let grey = |picture: &Option<Picture>| picture.as_ref().map(Picture::grey);
        let mut pictures = vec![grey(&self.blend), self.black.clone(), grey(&self.white)];
        while pictures.last().is_some_and(Option::is_none) {
            pictures.pop();
        }
        pictures
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn maps() -> Vec<VwfMap> {
        let values = |i: usize| if i == 2 { [f32::NAN; 3] } else { [i as f32 * 0.125, 0.25, 0.0] };
        let raster = Raster::new((3, 2), (0..6).map(values).collect()).unwrap();
        vec![
            VwfMap {
                name: "left".into(),
                points: false,
                raster: raster.clone(),
                blend: None,
                black: None,
                white: None,
            },
            VwfMap { name: "right".into(), points: true, raster, blend: None, black: None, white: None },
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
    fn pictures_are_read_back_with_their_map() {
        let picture = |factor: f32| {
            Some(Picture { size: (3, 2), values: [0.0, 0.2, 0.4, 0.6, 0.8, 1.0].map(|value| value * factor).to_vec() })
        };
        let mut all = maps();
        let black = [0.0, 0.05, 0.1, 0.15, 0.2, 0.25].map(|level| [level, 0.5 * level, 0.0]).to_vec();
        (all[0].blend, all[0].white) = (picture(1.0), picture(0.5));
        all[0].black = Some(Levels { size: (3, 2), values: black });
        all[1].white = picture(1.0);
        let back = read("a.vwf", &write(&all).unwrap()).unwrap();
        assert_eq!((back.value.len(), &back.notes[..]), (2, &[][..]));
        let near = |found: &Option<Picture>, expected: &Option<Picture>, bound: f32| match (found, expected) {
            (Some(a), Some(b)) => {
                a.size == b.size && a.values.iter().zip(&b.values).all(|(a, b)| (a - b).abs() <= bound)
            }
            (None, None) => true,
            _ => false,
        };
        for (found, expected) in back.value.iter().zip(&all) {
            assert!(
                near(&found.blend, &expected.blend, 1e-5) && near(&found.white, &expected.white, 1e-5),
                "{found:?}"
            );
            let values = |levels: &Option<Levels>| levels.as_ref().map_or(Vec::new(), |levels| levels.values.clone());
            let (a, b) = (values(&found.black), values(&expected.black));
            let close = a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() <= 0.002);
            assert!(a.len() == b.len() && close, "{found:?}");
        }
    }

    #[test]
    fn black_is_scaled_by_the_header_and_more_pictures_are_told() {
        let values = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];
        let picture = bmp::tests::bitmap(48, false, values);
        let single = write(&maps()[..1]).unwrap();
        let mut bytes = [single.as_slice(), &picture, &picture, &picture, &picture, &single[16..]].concat();
        bytes[4] = 6;
        let settings = 16 + 4 * (7 + 8 + BLACK_SCALE);
        bytes[settings..settings + 4].copy_from_slice(&0.5f32.to_le_bytes());
        let set = read("a.vwf", &bytes).unwrap();
        let of = |picture: &Option<Picture>| picture.as_ref().expect("has it").values[5];
        let map = &set.value[0];
        for (found, expected) in [(&map.blend, 1.0), (&map.white, 1.0)] {
            assert!((of(found) - expected).abs() < 1e-4);
        }
        let black = |set: Noted<Vec<VwfMap>>| set.value[0].black.as_ref().expect("has it").values[5][1];
        assert!(set.value.len() == 2 && set.value[1].blend.is_none());
        assert!(set.notes[0].contains("1 pictures are more than"), "{:?}", set.notes);
        assert!((black(set) - 0.5).abs() < 1e-4);
        // The file ends within the picture.
        assert!(read("a.vwf", &bytes[..single.len() + 60]).is_err());
        // A factor that is not a number counts as none.
        bytes[settings..settings + 4].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!((black(read("a.vwf", &bytes).unwrap()) - 1.0).abs() < 1e-4);
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
