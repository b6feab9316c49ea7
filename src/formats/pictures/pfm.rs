//! PFM, the portable float map: `PF` (three channels) or `Pf` (one), width and height, a scale
//! whose sign is the byte order, then 32-bit floats row by row from the **bottom**.
//!
//! Calibrations mark pixels that show nothing with NaN. The scale's size is not applied: writers of
//! calibrations give 1, and readers ignore it.

use crate::error::Result;
use crate::formats::grid::Raster;
use crate::formats::reading::input::{checked_size, invalid};
use crate::formats::reading::text::shown;

/// Longest header, bytes; those that Cupola writes have up to 20.
const LONGEST_HEADER: usize = 256;

/// True for the first bytes of a PFM file.
pub fn is_pfm(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PF") || bytes.starts_with(b"Pf")
}

/// Reads a PFM file; one channel gives three equal values. `name` is the file's, for messages.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) with the reason if the header is invalid, the
/// number of bytes is not that of the header (which is checked before anything is allocated), or a
/// value is infinite.
pub fn read(name: &str, bytes: &[u8]) -> Result<Raster> {
    let channels = match bytes.get(..2) {
        Some(b"PF") => 3,
        Some(b"Pf") => 1,
        _ => return Err(invalid(name, "is no PFM file; expected it to begin with PF or Pf")),
    };
    let mut header = Header { name, bytes: &bytes[..bytes.len().min(LONGEST_HEADER)], at: 2 };
    let width = header.count("width")?;
    let height = header.count("height")?;
    let scale = header.scale()?;
    let at = header.at;
    let size = checked_size(name, width, height)?;
    let needed = width as usize * height as usize * channels * 4;
    // One byte ends the header; two if the lines end as on Windows.
    let header = at + 1 + usize::from(bytes[at..].starts_with(b"\r\n") && bytes.len() == at + 2 + needed);
    if bytes.len() != header + needed {
        return Err(invalid(
            name,
            format!(
                "says {width} × {height} pixels with {channels} floats each, {needed} bytes; after the header of {header} \
                 there are {}",
                bytes.len() - header
            ),
        ));
    }
    let mut values = Vec::with_capacity(width as usize * height as usize);
    for row in bytes[header..].chunks_exact(width as usize * channels * 4).rev() {
        for pixel in row.chunks_exact(channels * 4) {
            let float = |channel: usize| {
                let raw = [0, 1, 2, 3].map(|byte| pixel[4 * channel + byte]);
                if scale < 0.0 { f32::from_le_bytes(raw) } else { f32::from_be_bytes(raw) }
            };
            values.push(if channels == 3 { [float(0), float(1), float(2)] } else { [float(0); 3] });
        }
    }
    if let Some(index) = values.iter().position(|pixel| pixel.iter().any(|value| value.is_infinite())) {
        let (column, row) = (index as u64 % width, index as u64 / width);
        return Err(invalid(
            name,
            format!(
                "column {column}, row {row} from the top has an infinite value; expected numbers, or NaN for nothing"
            ),
        ));
    }
    Raster::new(size, values).ok_or_else(|| invalid(name, "has no pixels"))
}

/// Words of a file's header after the first.
struct Header<'a> {
    /// Name of the file.
    name: &'a str,
    bytes: &'a [u8],
    /// Position of the search for the next word.
    at: usize,
}

impl<'a> Header<'a> {
    /// Returns the next word and its position; `what` describes it.
    fn word(&mut self, what: &str) -> Result<(&'a str, usize)> {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let start = self.at + rest.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let length = self.bytes[start..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
        let text = std::str::from_utf8(&self.bytes[start..start + length]).unwrap_or_default();
        self.at = start + length;
        if text.is_empty() || self.at == self.bytes.len() {
            return Err(invalid(self.name, format!("at byte {start}: the header ends; expected {what}")));
        }
        Ok((text, start))
    }

    /// Reads a number of pixels.
    fn count(&mut self, what: &str) -> Result<u64> {
        let (text, start) = self.word(&format!("the {what} in pixels"))?;
        let wrong = |_| invalid(self.name, format!("at byte {start}: {} is no {what} in pixels", shown(text)));
        text.parse().map_err(wrong)
    }

    fn scale(&mut self) -> Result<f64> {
        let (text, start) = self.word("the scale, -1.0 for little-endian values")?;
        let scale = text.parse::<f64>().ok().filter(|scale| scale.is_finite() && *scale != 0.0);
        let message = format!("at byte {start}: {} is no scale; expected -1.0 or 1.0", shown(text));
        scale.ok_or_else(|| invalid(self.name, message))
    }
}

/// Returns the bytes of a PFM file with three channels, little-endian, of values row by row from
/// the top. Their number must be a multiple of the width; NaN are written as they are.
pub fn write(width: u32, values: &[[f32; 3]]) -> Vec<u8> {
    let height = values.len() / width.max(1) as usize;
    let mut bytes = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
    bytes.reserve(values.len() * 12);
    for row in values.chunks_exact(width.max(1) as usize).rev() {
        bytes.extend(row.iter().flatten().flat_map(|value| value.to_le_bytes()));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_go_from_the_bottom_in_either_byte_order() {
        let floats = [1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0];
        let top_first = [[4.0, 5.0, 6.0], [1.0, 2.0, 3.0]];
        let little: Vec<u8> = floats.iter().flat_map(|value| value.to_le_bytes()).collect();
        let big: Vec<u8> = floats.iter().flat_map(|value| value.to_be_bytes()).collect();
        for (header, data) in [("PF\n1 2\n-1.0\n", &little), ("PF 1\n2 1\n", &big), ("PF\r\n1 2\r\n-1\r\n", &little)] {
            let raster = read("a.pfm", &[header.as_bytes(), data].concat()).unwrap();
            assert_eq!((raster.size(), raster.values()), ((1, 2), &top_first[..]), "{header:?}");
        }
        let grey = read("a.pfm", &[b"Pf\n3 2\n-1\n", &little[..]].concat()).unwrap();
        assert_eq!(grey.values()[0], [4.0; 3]);
    }

    #[test]
    fn a_first_float_that_begins_like_a_line_is_data() {
        let value = f32::from_le_bytes([b'\n', 1, 2, 0x3f]);
        let bytes = write(1, &[[value; 3]]);
        assert_eq!(read("a.pfm", &bytes).unwrap().values(), [[value; 3]]);
    }

    #[test]
    fn what_is_written_is_read_back() {
        let values: Vec<[f32; 3]> = (0..15).map(|i| [i as f32, -0.5, if i == 7 { f32::NAN } else { 1e-30 }]).collect();
        let raster = read("a.pfm", &write(5, &values)).unwrap();
        assert_eq!(raster.size(), (5, 3));
        let bits = |values: &[[f32; 3]]| values.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(raster.values()), bits(&values));
    }

    #[track_caller]
    fn refused(bytes: &[u8], why: &str) {
        let message = read("a.pfm", bytes).unwrap_err().message;
        assert!(message.starts_with("a.pfm: ") && message.contains(why), "{message}");
    }

    #[test]
    fn damaged_files_are_refused() {
        refused(b"", "no PFM");
        refused(b"PF", "header ends");
        refused(b"PF\n3 2", "header ends");
        refused(b"PF\n3 x\n-1\n....", "no height");
        refused(b"PF\n3 2\n0\n....", "no scale");
        refused(b"PF\n65536 65536\n-1\n....", "65536 × 65536");
        refused(b"PF\n18446744073709551615 2\n-1\n....", "pixels altogether");
        refused(b"PF\n0 2\n-1\n....", "0 × 2");
        refused(&write(2, &[[1.0; 3]; 4])[..40], "there are");
        refused(&write(2, &[[1.0; 3], [f32::INFINITY; 3]]), "column 1, row 0");
    }
}
