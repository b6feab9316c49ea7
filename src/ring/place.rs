//! Path of the file.

use super::layout::{self, header, value};
use crate::system::{self, SharedMemory};
use std::path::{Path, PathBuf};

/// Path of the file where none is named: one for each user.
pub fn default_path() -> PathBuf {
    let memory = Path::new("/dev/shm");
    let folder = std::iter::once(memory.to_owned()).chain(system::variable("XDG_RUNTIME_DIR").map(PathBuf::from));
    let folder = folder.into_iter().find(|folder| folder.is_dir()).unwrap_or_else(std::env::temp_dir);
    folder.join(format!("cupola-{}", system::user()))
}

/// Removes the file of a writer that ended without removing it. Any other file stays.
pub fn remove_if_ended(path: &Path) {
    let ended = SharedMemory::open(path).is_ok_and(|memory| {
        memory.words().len() >= layout::FIRST_SLOT
            && value(&memory, header::MAGIC) == layout::MAGIC
            && !memory.is_locked(header::WRITER_LOCK * 8)
    });
    if ended {
        // Another process may have removed it meanwhile.
        let _ = std::fs::remove_file(path);
    }
}
