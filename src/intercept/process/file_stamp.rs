//! Stamps of files, which show whether a file has changed.

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
