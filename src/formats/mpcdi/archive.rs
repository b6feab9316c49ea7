//! Reads files in the zip archive, within limits.

use crate::error::Result;
use crate::formats::reading::input::{LONGEST_FILE, invalid};
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// Longest description, bytes.
pub(super) const LONGEST_DESCRIPTION: u64 = 1 << 22;

/// An open archive.
pub(super) struct Files<'a> {
    name: &'a str,
    zip: ZipArchive<Cursor<&'a [u8]>>,
}

impl<'a> Files<'a> {
    /// Reads the archive's directory.
    pub(super) fn open(name: &'a str, bytes: &'a [u8]) -> Result<Self> {
        let zip = ZipArchive::new(Cursor::new(bytes))
            .map_err(|error| invalid(name, format!("is no zip archive that can be read: {error}")))?;
        Ok(Self { name, zip })
    }

    /// Returns the description's name, with the archive's before it, and its text: `mpcdi.xml`, in
    /// old archives `mpacs.xml`, otherwise the only XML file.
    pub(super) fn description(&mut self) -> Result<(String, String)> {
        let names: Vec<String> = self.zip.file_names().flatten().map(|name| name.into_owned()).collect();
        let called = |wanted: &str| names.iter().find(|name| name.eq_ignore_ascii_case(wanted));
        let mut others = names.iter().filter(|name| name.to_lowercase().ends_with(".xml"));
        let found = called("mpcdi.xml").or_else(|| called("mpacs.xml")).or_else(|| others.next());
        let found = found.ok_or_else(|| invalid(self.name, "has no mpcdi.xml"))?;
        let bytes = self.take(found, LONGEST_DESCRIPTION)?;
        let name = format!("{}/{found}", self.name);
        let text = String::from_utf8(bytes).map_err(|_| invalid(&name, "is not UTF-8 text"))?;
        Ok((name, text))
    }

    /// Unpacks a file of at most `longest` bytes.
    pub(super) fn take(&mut self, path: &str, longest: u64) -> Result<Vec<u8>> {
        let longest = longest.min(LONGEST_FILE);
        let wrong = |why: String| invalid(&format!("{}/{path}", self.name), why);
        if path.starts_with('/') || path.contains(['\\', ':']) || path.split('/').any(|part| part == "..") {
            return Err(wrong("leads out of the archive; expected the name of a file in it".into()));
        }
        let file = self.zip.by_name(path).map_err(|error| wrong(format!("cannot be unpacked: {error}")))?;
        let mut bytes = Vec::new();
        // The length in the directory may be wrong: the unpacked bytes count.
        let read = file.take(longest + 1).read_to_end(&mut bytes);
        read.map_err(|error| wrong(format!("cannot be unpacked: {error}")))?;
        if bytes.len() as u64 > longest {
            return Err(wrong(format!(
                "unpacks to more than {longest} bytes; expected no more for a region of its size"
            )));
        }
        Ok(bytes)
    }
}
