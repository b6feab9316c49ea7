//! Files that a run was asked for, and whether the program's library has written them.

use super::Inspection;
use super::options::Options;
use crate::failure::Failure;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// A file, with its time and length, which show whether it was written again.
type Stamp = (PathBuf, SystemTime, u64);

/// Files that exist for `file` now; for a capture of several outputs all that have its name.
fn stamps(file: &Path, several: bool) -> Vec<Stamp> {
    let stem = format!("{}-", file.file_stem().unwrap_or_default().to_string_lossy());
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().filter(|_| several);
    let others = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(&stem));
    let files = std::iter::once(file.to_owned()).chain(others.map(|entry| entry.path()));
    let stamp = |path: PathBuf| {
        let data = std::fs::metadata(&path).ok()?;
        Some((path, data.modified().ok()?, data.len()))
    };
    files.filter_map(stamp).collect()
}

/// Requested files, with the state before the program started.
pub(super) struct Expected(Vec<(PathBuf, bool, Vec<Stamp>)>);

impl Expected {
    pub(super) fn new(arguments: &Options, inspection: Option<&Inspection>) -> Self {
        let page = inspection.map(|inspection| (&inspection.output, false));
        let capture = arguments.capture.as_ref().map(|file| (file, true));
        let statistics = arguments.stats.as_ref().map(|file| (file, false));
        let files = [capture, statistics, page].into_iter().flatten();
        Self(files.map(|(file, several)| (file.clone(), several, stamps(file, several))).collect())
    }

    /// Files that were not written. One picture is enough for several outputs.
    pub(super) fn missing(&self) -> impl Iterator<Item = &Path> {
        let is_written = |file: &Path, several: bool, before: &[Stamp]| {
            stamps(file, several).iter().any(|stamp| !before.contains(stamp))
        };
        self.0.iter().filter(move |(file, several, before)| !is_written(file, *several, before)).map(|file| &*file.0)
    }

    /// Fails if one of the files was not written.
    pub(super) fn check(&self, arguments: &Options) -> Result<(), Failure> {
        let Some(file) = self.missing().next() else { return Ok(()) };
        let frames = arguments.frames.map_or_else(|| "no frame".to_owned(), |n| format!("fewer than {n} frames"));
        Err(Failure::new(format!(
            "{} was not written: the program presented {frames} with OpenGL or Vulkan in time, or Cupola left it alone \
             (see the messages above, and cupola doctor)",
            file.display()
        )))
    }
}
