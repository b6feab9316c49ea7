//! Results of long computations, kept by what they were computed from: in files for the next start, and small ones in
//! memory for the next time they are asked for.
//!
//! What is kept is a saving and nothing else: a file that is missing, damaged, of another build or somebody else's is computed again,
//! and where nothing can be written nothing is kept. A file appears under its name when it is whole.

mod bytes;
#[cfg(test)]
mod tests;

pub use bytes::{Reader, Writer};

use crate::digest::Digest;
use serde::Serialize;
use std::collections::VecDeque;
use std::fmt::{self, Write as _};
use std::fs::{self, File, OpenOptions};
use std::io::{Read, Write as _};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

/// All files together have at most so many bytes; the ones longest not used go first.
const MOST_BYTES: u64 = 1 << 30;
/// A file has at most so many: a table of 4096² pixels.
const MOST_IN_FILE: u64 = MOST_BYTES / 4;
/// How many files there may be when a process begins to write some.
const MOST_FILES: usize = 4096;
/// A process writes at most so many bytes and files: one whose rig or size changes all the time does not fill the disk.
const MOST_WRITTEN: u64 = MOST_BYTES / 2;
const MOST_WRITTEN_FILES: u64 = 512;
/// Contents of at most so many bytes stay in memory …
const MOST_IN_MEMORY: usize = 1 << 16;
/// … the so many that were used last.
const REMEMBERED: usize = 64;
/// The time of a file that is used is renewed when it is older than this.
const RENEWED_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

/// What files begin with.
const MAGIC: &[u8; 16] = b"cupola cache 1\r\n";
/// Magic, key, length and sum of the content.
const HEADER: usize = 16 + 16 + 8 + 16;

/// What was asked of a cache so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Results that were found in files.
    pub read: u64,
    /// Results that were found nowhere.
    pub missing: u64,
    /// Files that were written.
    pub written: u64,
}

/// Where results are kept. Cheap to clone; clones are the same cache.
#[derive(Clone, Debug, Default)]
pub struct Cache(Option<Arc<Shared>>);

#[derive(Debug)]
struct Shared {
    /// The folder, and what tells this build from others; `None`: only memory.
    files: Option<(PathBuf, Vec<u8>)>,
    recent: Mutex<VecDeque<(String, Arc<Vec<u8>>)>>,
    read: AtomicU64,
    missing: AtomicU64,
    written: AtomicU64,
    /// Bytes of the files that were written.
    bytes: AtomicU64,
}

/// What a result is computed from, as a sum: [`Digest`].
#[derive(Debug, Default)]
pub struct Key(Digest);

impl Key {
    /// Adds a value as [`Debug`](fmt::Debug) writes it: all of the value must show there. Numbers do, to the bit but for kinds of NaN.
    pub fn debug(mut self, value: &impl fmt::Debug) -> Self {
        // Adding cannot fail, and an implementation of Debug that fails would have nothing to say.
        let _ = write!(self.0, "{value:?}");
        self.0.add(0);
        self
    }

    /// Adds bytes and how many they are.
    pub fn bytes(mut self, bytes: &[u8]) -> Self {
        self.0.add_bytes(bytes);
        self
    }
}

impl Cache {
    /// Keeps nothing.
    pub fn none() -> Self {
        Self::default()
    }

    /// Whether it keeps nothing.
    pub fn is_none(&self) -> bool {
        self.0.is_none()
    }

    /// Keeps small results for the life of the process.
    pub fn in_memory() -> Self {
        Self::new(None)
    }

    /// Keeps results in files in `folder`, which is made when it is needed, readable by this user only. `build` tells
    /// the code that computes them from other code that may compute something else.
    pub fn in_folder(folder: PathBuf, build: &[u8]) -> Self {
        Self::new(Some((folder, build.to_vec())))
    }

    fn new(files: Option<(PathBuf, Vec<u8>)>) -> Self {
        let zero = || AtomicU64::new(0);
        let shared =
            Shared { files, recent: Mutex::default(), read: zero(), missing: zero(), written: zero(), bytes: zero() };
        Self(Some(Arc::new(shared)))
    }

    /// What was asked so far.
    pub fn counts(&self) -> Counts {
        let Some(shared) = &self.0 else { return Counts::default() };
        let count = |number: &AtomicU64| number.load(Ordering::Relaxed);
        Counts { read: count(&shared.read), missing: count(&shared.missing), written: count(&shared.written) }
    }

    /// The result of `compute`, or what was kept of one for the same `key` and `kind` (lower case letters, `-`).
    ///
    /// `decode` gets what `encode` wrote, or anything else that somebody put there: it says `None` where that makes no
    /// sense. `encode` returns `false` where the result is not to be kept. Nothing is kept of an error.
    ///
    /// # Errors
    /// Those of `compute`.
    pub fn kept<T, E>(
        &self,
        kind: &str,
        key: impl FnOnce(Key) -> Key,
        decode: impl FnOnce(&mut Reader<'_>) -> Option<T>,
        encode: impl FnOnce(&T, &mut Writer) -> bool,
        compute: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let Some(shared) = &self.0 else { return compute() };
        let mut key = key(Key::default().bytes(kind.as_bytes()));
        if let Some((_, build)) = &shared.files {
            key.0.add_bytes(build);
        }
        let name = format!("{kind}-{:032x}", key.0);
        let whole = |bytes: &[u8]| {
            let mut reader = Reader::new(bytes);
            decode(&mut reader).filter(|_| reader.is_at_end())
        };
        if let Some(known) = shared.find(&name, key.0).and_then(|bytes| whole(&bytes)) {
            return Ok(known);
        }
        shared.missing.fetch_add(1, Ordering::Relaxed);
        let value = compute()?;
        let mut writer = Writer::default();
        if encode(&value, &mut writer) {
            shared.keep(name, key.0, writer.finish());
        }
        Ok(value)
    }
}

impl Shared {
    fn find(&self, name: &str, key: Digest) -> Option<Arc<Vec<u8>>> {
        if let Some(content) = self.recall(name) {
            return Some(content);
        }
        let (folder, _) = self.files.as_ref()?;
        let content = Arc::new(read(&folder.join(name), key)?);
        self.read.fetch_add(1, Ordering::Relaxed);
        self.remember(name.to_owned(), &content);
        Some(content)
    }

    fn keep(&self, name: String, key: Digest, content: Vec<u8>) {
        if let Some((folder, _)) = &self.files {
            self.write(folder, &name, key, &content);
        }
        self.remember(name, &Arc::new(content));
    }

    fn write(&self, folder: &Path, name: &str, key: Digest, content: &[u8]) {
        let (files, bytes) = (self.written.load(Ordering::Relaxed), self.bytes.load(Ordering::Relaxed));
        if files >= MOST_WRITTEN_FILES || bytes + content.len() as u64 > MOST_WRITTEN {
            return;
        }
        if files == 0 {
            sweep(folder, MOST_BYTES - MOST_WRITTEN, MOST_FILES);
        }
        if write(folder, name, key, content).is_some() {
            self.written.fetch_add(1, Ordering::Relaxed);
            self.bytes.fetch_add(content.len() as u64, Ordering::Relaxed);
        }
    }

    fn recall(&self, name: &str) -> Option<Arc<Vec<u8>>> {
        let mut recent = self.recent.lock().unwrap_or_else(PoisonError::into_inner);
        let place = recent.iter().position(|(other, _)| other == name)?;
        let found = recent.remove(place)?;
        let content = found.1.clone();
        recent.push_front(found);
        Some(content)
    }

    fn remember(&self, name: String, content: &Arc<Vec<u8>>) {
        if content.len() > MOST_IN_MEMORY {
            return;
        }
        let mut recent = self.recent.lock().unwrap_or_else(PoisonError::into_inner);
        recent.push_front((name, content.clone()));
        recent.truncate(REMEMBERED);
    }
}

fn sum(content: &[u8]) -> [u8; 16] {
    let mut digest = Digest::default();
    digest.add_bytes(content);
    digest.value().to_le_bytes()
}

fn header(key: Digest, content: &[u8]) -> Vec<u8> {
    let length = (content.len() as u64).to_le_bytes();
    [&MAGIC[..], &key.value().to_le_bytes(), &length, &sum(content)].concat()
}

/// The number of the user whose process this is.
pub fn this_user() -> Option<u32> {
    Some(fs::metadata("/proc/self").ok()?.uid())
}

/// The content of a file, if it is this user's, whole, and of this key.
fn read(path: &Path, key: Digest) -> Option<Vec<u8>> {
    let mut file = File::open(path).ok()?;
    let about = file.metadata().ok()?;
    if !about.is_file() || Some(about.uid()) != this_user() || about.len() > MOST_IN_FILE + HEADER as u64 {
        return None;
    }
    let mut found = [0; HEADER];
    file.read_exact(&mut found).ok()?;
    let mut content = Vec::with_capacity((about.len() as usize).saturating_sub(HEADER));
    file.take(MOST_IN_FILE).read_to_end(&mut content).ok()?;
    if found[..] != header(key, &content)[..] {
        return None;
    }
    let now = SystemTime::now();
    let age = about.modified().ok().and_then(|time| now.duration_since(time).ok());
    if age.is_none_or(|age| age > RENEWED_AFTER)
        && let Ok(file) = OpenOptions::new().append(true).open(path)
    {
        // A file whose time cannot be renewed goes earlier.
        let _ = file.set_modified(now);
    }
    Some(content)
}

/// Writes a file under another name and renames it; `None` where that fails, with nothing left.
fn write(folder: &Path, name: &str, key: Digest, content: &[u8]) -> Option<()> {
    if content.len() as u64 > MOST_IN_FILE {
        return None;
    }
    fs::DirBuilder::new().recursive(true).mode(0o700).create(folder).ok()?;
    if Some(fs::metadata(folder).ok()?.uid()) != this_user() {
        return None;
    }
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let partial = folder.join(format!(".{name}.{}.{number}", std::process::id()));
    let whole = || -> std::io::Result<()> {
        let mut file = OpenOptions::new().write(true).create_new(true).mode(0o600).open(&partial)?;
        file.write_all(&header(key, content))?;
        file.write_all(content)?;
        drop(file);
        fs::rename(&partial, folder.join(name))
    };
    let result = whole();
    if result.is_err() {
        // It may not be there; what is left is swept away later.
        let _ = fs::remove_file(&partial);
    }
    result.ok()
}

/// Removes the files longest not used, until there are at most three quarters of `bytes` and of `files` of them, where
/// there are more than that; parts of files that nobody finished count like others.
fn sweep(folder: &Path, bytes: u64, files: usize) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let mut known: Vec<(SystemTime, u64, PathBuf)> = entries
        .flatten()
        .filter_map(|entry| {
            let about = entry.metadata().ok().filter(|about| about.is_file())?;
            Some((about.modified().ok()?, about.len(), entry.path()))
        })
        .collect();
    let mut total: u64 = known.iter().map(|file| file.1).sum();
    if total <= bytes && known.len() <= files {
        return;
    }
    known.sort();
    let mut count = known.len();
    for (_, length, path) in known {
        if total <= bytes / 4 * 3 && count <= files / 4 * 3 {
            break;
        }
        if fs::remove_file(&path).is_ok() {
            total -= length;
            count -= 1;
        }
    }
}
