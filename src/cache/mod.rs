//! Cache of results of long computations, found by the input of the computation: in files for the
//! next start, and small ones in memory for the next request.
//!
//! A cached result saves time and nothing else. If a file is missing, damaged, of another build or
//! of another user, its result is computed again; where nothing can be written, nothing is cached.
//! A file gets its name only when it is complete.

#[cfg(test)]
mod tests;

use crate::digest::Digest;
use crate::lock::Lock;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::fs::{self, File, OpenOptions};
use std::io::{Read, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};

/// Greatest number of bytes of all files together; the files that were not used for longest are
/// removed first.
const MOST_BYTES: u64 = 1 << 30;
/// Greatest number of bytes of a file: a table of 4096² pixels.
const MOST_IN_FILE: u64 = MOST_BYTES / 4;
/// Greatest number of files when a process begins to write.
const MOST_FILES: usize = 4096;
/// Greatest number of bytes, and of files, that a process writes. So a process whose rig or size
/// changes all the time does not fill the disk.
const MOST_WRITTEN: u64 = MOST_BYTES / 2;
const MOST_WRITTEN_FILES: u64 = 512;
/// Largest result that is cached in memory, bytes.
const MOST_IN_MEMORY: usize = 1 << 16;
/// Greatest number of results that are cached in memory.
const REMEMBERED: usize = 64;
/// Age at which the time of a file is renewed when the file is used.
const RENEWED_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

/// First bytes of a file.
const MAGIC: &[u8; 16] = b"cupola cache 2\r\n";
/// Length of a file's header: magic, key, length and sum of the content.
const HEADER: usize = 16 + 16 + 8 + 16;

/// Numbers of requests to a cache.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Number of results that were found in files.
    pub read: u64,
    /// Number of results that were found nowhere.
    pub missing: u64,
    /// Number of files that were written.
    pub written: u64,
}

/// Cache of results. Cheap to clone; clones share their content.
#[derive(Clone, Debug, Default)]
pub struct Cache(Option<Arc<Shared>>);

#[derive(Debug)]
struct Shared {
    /// Folder, and the bytes that identify this build; `None`: only memory.
    files: Option<(PathBuf, Vec<u8>)>,
    recent: Mutex<VecDeque<(String, Arc<Vec<u8>>)>>,
    read: AtomicU64,
    missing: AtomicU64,
    written: AtomicU64,
    /// Number of bytes of the files that were written.
    bytes: AtomicU64,
}

/// Returns a value as bytes: postcard's format, without names. `None` for a value that has no
/// bytes, such as a path that is not UTF-8.
pub fn encode(value: &(impl Serialize + ?Sized)) -> Option<Vec<u8>> {
    postcard::to_stdvec(value).ok()
}

/// Returns the value of `bytes`; `None` unless all of them can be decoded.
pub fn decode<'bytes, T: Deserialize<'bytes>>(bytes: &'bytes [u8]) -> Option<T> {
    let (value, rest) = postcard::take_from_bytes(bytes).ok()?;
    rest.is_empty().then_some(value)
}

/// Bytes in an encoded value: they are copied unchanged.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(transparent)]
pub struct RawBytes<'bytes>(#[serde(borrow)] pub &'bytes [u8]);

impl Serialize for RawBytes<'_> {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_bytes(self.0)
    }
}

impl Cache {
    /// Returns a cache that stores nothing.
    pub fn none() -> Self {
        Self::default()
    }

    /// True if it stores nothing.
    pub fn is_none(&self) -> bool {
        self.0.is_none()
    }

    /// Returns a cache that stores small results for the life of the process.
    pub fn in_memory() -> Self {
        Self::new(None)
    }

    /// Returns a cache that stores results in files in `folder`, which is created when it is
    /// needed, readable by this user only. `build` identifies the code that computes them, because
    /// other code may compute other results.
    pub fn in_folder(folder: PathBuf, build: &[u8]) -> Self {
        Self::new(Some((folder, build.to_vec())))
    }

    fn new(files: Option<(PathBuf, Vec<u8>)>) -> Self {
        let zero = || AtomicU64::new(0);
        let shared =
            Shared { files, recent: Mutex::default(), read: zero(), missing: zero(), written: zero(), bytes: zero() };
        Self(Some(Arc::new(shared)))
    }

    /// Returns the numbers of requests so far.
    pub fn counts(&self) -> Counts {
        let Some(shared) = &self.0 else { return Counts::default() };
        let count = |number: &AtomicU64| number.load(Ordering::Relaxed);
        Counts { read: count(&shared.read), missing: count(&shared.missing), written: count(&shared.written) }
    }

    /// Returns the result of `compute`, or the cached one for the same `kind` (lower case letters,
    /// `-`) and `key`. A value from a file is used only if `is_sound`, because anybody may have
    /// written the file.
    ///
    /// # Errors
    /// Errors of `compute`; they are not cached.
    pub fn cached<T: Serialize + DeserializeOwned, E>(
        &self,
        kind: &str,
        key: &impl Serialize,
        is_sound: impl FnOnce(&T) -> bool,
        compute: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        self.cached_as(kind, key, |bytes| decode(bytes).filter(is_sound), |value| encode(value), compute)
    }

    /// As [`Cache::cached`], with functions of the caller between the value and its bytes.
    ///
    /// `decode` gets the bytes of `encode`, or anything else that somebody put there, and returns
    /// `None` if they have no meaning. `encode` returns `None` if the result is not to be cached.
    ///
    /// # Errors
    /// Errors of `compute`; they are not cached.
    pub fn cached_as<T, E>(
        &self,
        kind: &str,
        key: &impl Serialize,
        decode: impl FnOnce(&[u8]) -> Option<T>,
        encode: impl FnOnce(&T) -> Option<Vec<u8>>,
        compute: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let Some(shared) = &self.0 else { return compute() };
        let build = shared.files.as_ref().map_or(&[][..], |(_, build)| build);
        let sum = |to: &mut dyn Write| postcard::to_io(&(kind, key, build), to).ok().map(|_| ());
        // A value that cannot be serialised cannot be distinguished from others.
        let Some(key) = Digest::of_written(sum) else { return compute() };
        let name = format!("{kind}-{key:032x}");
        if let Some(known) = shared.find(&name, key).and_then(|bytes| decode(&bytes)) {
            return Ok(known);
        }
        shared.missing.fetch_add(1, Ordering::Relaxed);
        let value = compute()?;
        if let Some(bytes) = encode(&value) {
            shared.keep(name, key, bytes);
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
        let mut recent = self.recent.locked();
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
        let mut recent = self.recent.locked();
        recent.push_front((name, content.clone()));
        recent.truncate(REMEMBERED);
    }
}

fn header(key: Digest, content: &[u8]) -> Vec<u8> {
    let length = (content.len() as u64).to_le_bytes();
    [&MAGIC[..], &key.value().to_le_bytes(), &length, &Digest::of(content).value().to_le_bytes()].concat()
}

/// Number of the user of this process.
pub fn this_user() -> Option<u32> {
    Some(fs::metadata("/proc/self").ok()?.uid())
}

/// Content of a file, if it belongs to this user, is complete, and has this key.
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
        // A file whose time cannot be renewed is removed earlier.
        let _ = file.set_modified(now);
    }
    Some(content)
}

/// Writes a file under another name and renames it. Returns `None`, and leaves nothing behind, if
/// that fails.
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
        // The file may not exist; if it stays, a later call of `sweep` removes it.
        let _ = fs::remove_file(&partial);
    }
    result.ok()
}

/// If there are more than `bytes` or `files`, removes the files that were not used for longest
/// until three quarters are left. Unfinished files count like others.
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
