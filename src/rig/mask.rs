//! Weight images of a rig.

use crate::error::Result;
use crate::formats::{png_luma, read_file};
use std::io::Read;
use std::path::Path;

/// Reads a weight image: a PNG of 8 or 16 bits, grey or colour (its luma counts; transparency does
/// not). Returns its size and a weight for each pixel, row by row from the top, 65535 = 1.
///
/// # Errors
/// [`ErrorKind::Io`](crate::ErrorKind::Io) if the file cannot be read,
/// [`ErrorKind::InvalidRig`](crate::ErrorKind::InvalidRig) if it is no such image.
pub fn read_mask(path: &Path) -> Result<((u32, u32), Vec<u16>)> {
    png_luma(&format!("mask {}", path.display()), &read_file(path)?)
}

/// Returns the reason why the file cannot be a mask; `None` if it can.
pub(super) fn unusable(path: &Path) -> Option<String> {
    let mut signature = [0; 8];
    // Opening a named pipe would wait for a writer.
    let read = std::fs::metadata(path).and_then(|about| match about.is_file() {
        true => std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut signature)),
        false => Err(std::io::Error::other("it is no file")),
    });
    match read {
        Ok(()) if signature == *b"\x89PNG\r\n\x1a\n" => None,
        Err(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => Some(format!(
            "{} cannot be read: {error}; expected a grey PNG file, relative to the rig file",
            path.display()
        )),
        _ => Some(format!("{} is no PNG file; expected a grey PNG file", path.display())),
    }
}
