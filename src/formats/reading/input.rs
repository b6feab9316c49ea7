//! Common parts of all readers: limits, and the form of their errors.

use crate::error::{Error, ErrorKind, Result};
use std::io::Read;
use std::path::Path;

/// Longest file that is read, bytes: a map of 8192 × 8192 pixels with four floats each.
pub const LONGEST_FILE: u64 = 1 << 30;
/// Greatest number of pixels of a map or a picture: 8192 × 8192.
pub const MOST_PIXELS: u64 = 1 << 26;
/// Greatest number of pixels of all maps and pictures of a file together: 2 GiB as floats.
pub const MOST_PIXELS_TOGETHER: u64 = 1 << 28;
/// Longest document of nested values (JSON), bytes: in memory it takes up to thirty times as much.
pub const LONGEST_DOCUMENT: usize = 1 << 24;

/// Result of a reader, with its assumptions.
#[derive(Clone, Debug, PartialEq)]
pub struct Noted<T> {
    /// Content of the file.
    pub value: T,
    /// Notes for people: facts that the file leaves open or that readers interpret differently, and
    /// the interpretation that was used.
    pub notes: Vec<String>,
}

/// Reads a whole file of at most [`LONGEST_FILE`] bytes.
///
/// # Errors
/// [`ErrorKind::Io`] if it cannot be read, [`ErrorKind::InvalidRig`] if it is longer or no regular
/// file. A pipe may have no end, or never begin.
pub fn read_file(path: &Path) -> Result<Vec<u8>> {
    read_at_most(path, LONGEST_FILE)
}

/// As [`read_file`], with a limit of `longest` bytes.
///
/// # Errors
/// Errors of [`read_file`].
pub fn read_at_most(path: &Path, longest: u64) -> Result<Vec<u8>> {
    let name = path.display();
    let unreadable = |error| Error::new(ErrorKind::Io, format!("{name} cannot be read: {error}"));
    // Opening a named pipe would wait for a writer.
    let about = std::fs::metadata(path).map_err(unreadable)?;
    if !about.is_file() {
        return Err(invalid(&name.to_string(), "is no file"));
    }
    let too_long = || invalid(&name.to_string(), format!("is longer than {longest} bytes; expected a shorter file"));
    if about.len() > longest {
        return Err(too_long());
    }
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::with_capacity(about.len() as usize);
    file.take(longest + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > longest {
        return Err(too_long());
    }
    Ok(bytes)
}

/// Error of the file `name`.
pub(in crate::formats) fn invalid(name: &str, why: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::InvalidRig, format!("{name}: {why}"))
}

/// Width and height from a header, if a picture of that size fits into the limits.
///
/// # Errors
/// [`ErrorKind::InvalidRig`] if one of them is 0 or there are more than [`MOST_PIXELS`].
pub(in crate::formats) fn checked_size(name: &str, width: u64, height: u64) -> Result<(u32, u32)> {
    let pixels = width.checked_mul(height).filter(|pixels| (1..=MOST_PIXELS).contains(pixels));
    match (u32::try_from(width), u32::try_from(height), pixels) {
        (Ok(width), Ok(height), Some(_)) => Ok((width, height)),
        _ => Err(invalid(
            name,
            format!("says that it has {width} × {height} pixels; expected 1 to {MOST_PIXELS} pixels altogether"),
        )),
    }
}

/// Reads a PNG picture of any kind, within limits.
pub(in crate::formats) fn png(name: &str, bytes: &[u8]) -> Result<image::DynamicImage> {
    let reader = || {
        let mut reader = image::ImageReader::with_format(std::io::Cursor::new(bytes), image::ImageFormat::Png);
        let mut limits = image::Limits::default();
        limits.max_alloc = Some(LONGEST_FILE / 2);
        reader.limits(limits);
        reader
    };
    let refused = |error| invalid(name, format!("is no PNG picture that can be read: {error}"));
    // A few kilobytes can unpack to any number of black pixels.
    let (width, height) = reader().into_dimensions().map_err(refused)?;
    checked_size(name, width.into(), height.into())?;
    reader().decode().map_err(refused)
}

/// Size and values (0…65535, row by row from the top) of a PNG picture, by its luma.
///
/// # Errors
/// [`ErrorKind::InvalidRig`] with the reason.
pub fn png_luma(name: &str, bytes: &[u8]) -> Result<((u32, u32), Vec<u16>)> {
    let grey = png(name, bytes)?.into_luma16();
    let size = grey.dimensions();
    Ok((size, grey.into_raw()))
}
