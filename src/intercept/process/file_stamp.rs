//! Stamps of files, which show whether a file has changed, and checksums of their texts.

use crate::ring::text_sum;
use std::path::Path;
use std::time::SystemTime;

/// Time of the last change and length of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileStamp {
    modified: Option<SystemTime>,
    length: u64,
}

impl FileStamp {
    /// Returns the stamp of a file; `None` if there is no such file.
    pub fn of(path: &Path) -> Option<Self> {
        let data = std::fs::metadata(path).ok()?;
        Some(Self { modified: data.modified().ok(), length: data.len() })
    }
}

/// Returns the checksum of a file's text; 0 if it cannot be read.
pub fn text_sum_of(path: &Path) -> u64 {
    std::fs::read(path).map_or(0, |text| text_sum(&text))
}
