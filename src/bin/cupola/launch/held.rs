//! Programs whose time is held and goes on by single frames, each by a page that it shares with
//! `cupola run`.

#[path = "../../../clock/page.rs"]
mod page;

use super::clock::Rate;
use cupola::ring;
use cupola::system::SharedMemory;
use page::Page;
use serde_json::{Value, json};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Byte of the file that `cupola run` keeps locked for as long as it runs.
const LOCK: usize = 0;
/// Longest time in which the picture of the last step is expected.
const PATIENCE: Duration = Duration::from_secs(2);
/// Interval at which it is looked for.
const LOOK: Duration = Duration::from_millis(2);

/// A request for a program's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request {
    /// Hold it.
    Hold,
    /// Let it go on.
    Release,
    /// Let it go on by this number of frames, and hold it then.
    Step(u64),
}

/// The page of a program that this process has started. Its file is removed with this value.
pub struct Held {
    _memory: SharedMemory,
    path: PathBuf,
}

impl Held {
    /// Makes the page of a new program. `path`: `None` for the usual one. `holds`: its time is held
    /// after the first frame.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn new(path: Option<&Path>, rate: Rate, holds: bool) -> io::Result<Self> {
        let path = path.map_or_else(|| folder().join(format!("{}{}", prefix(), std::process::id())), Path::to_owned);
        // A process of the same number may have left a file behind.
        let _ = std::fs::remove_file(&path);
        let memory = SharedMemory::create(&path, page::WORDS * size_of::<u64>())?;
        memory.lock(LOCK);
        Page::begin(memory.words(), (rate.frames, rate.seconds), holds);
        Ok(Self { _memory: memory, path })
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        // Somebody may have removed it already.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Folder of the usual pages.
fn folder() -> PathBuf {
    ring::default_path().parent().unwrap_or(Path::new("/dev/shm")).to_owned()
}

/// Beginning of their names.
fn prefix() -> String {
    format!("{}-clock-", ring::default_path().file_name().unwrap_or_default().to_string_lossy())
}

/// Pages of the programs of this user that `cupola run` runs now. Pages of commands that were
/// killed are removed.
pub fn all() -> Vec<PathBuf> {
    let prefix = prefix();
    let entries = std::fs::read_dir(folder()).into_iter().flatten().flatten();
    let ours = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix));
    let mut pages: Vec<PathBuf> = ours.map(|entry| entry.path()).filter(|path| is_in_use(path)).collect();
    pages.sort();
    pages
}

fn is_in_use(path: &Path) -> bool {
    let Ok(memory) = SharedMemory::open(path) else { return false };
    let is_locked = memory.is_locked(LOCK);
    if Page::new(memory.words()).is_some() && !is_locked {
        // Another process may have removed it meanwhile.
        let _ = std::fs::remove_file(path);
    }
    is_locked
}

/// Executes a request, and returns the state as [`state`] does.
///
/// # Errors
/// Description of why there is no such page.
pub fn apply(path: &Path, request: Request) -> Result<Value, String> {
    with(path, |page| {
        match request {
            Request::Hold => page.hold(),
            Request::Release => page.release(),
            Request::Step(frames) => page.step(frames),
        }
        described(page)
    })
}

/// State of a program's time: its frame and seconds, whether it is held, and whether it stands.
///
/// # Errors
/// As for [`apply`].
pub fn state(path: &Path) -> Result<Value, String> {
    with(path, described)
}

fn with<R>(path: &Path, act: impl FnOnce(Page<'_>) -> R) -> Result<R, String> {
    let memory = SharedMemory::open(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let page = Page::new(memory.words());
    page.map(act).ok_or_else(|| format!("{}: this is no file of a program's clock", path.display()))
}

fn described(page: Page<'_>) -> Value {
    let frame = page.complete();
    json!({
        "frame": frame,
        "seconds": frame.map(|frame| page.seconds(frame)),
        "held": page.until() != page::NEVER,
        "stands": page.stands(),
    })
}

/// Asks for the state until the time stands, for some seconds.
///
/// # Errors
/// Those of `ask`.
pub fn until_it_stands(mut ask: impl FnMut() -> Result<Value, String>) -> Result<Value, String> {
    let begin = Instant::now();
    loop {
        let state = ask()?;
        if state["stands"] == true || state["held"] == false || begin.elapsed() > PATIENCE {
            return Ok(state);
        }
        std::thread::sleep(LOOK);
    }
}

/// Describes a state in words.
pub fn words(state: &Value) -> String {
    let held = if state["held"] == true { "time stands" } else { "time goes on" };
    match (state["frame"].as_u64(), state["seconds"].as_f64()) {
        (Some(frame), Some(seconds)) if state["stands"] == true || state["held"] == false => {
            format!("{held} at frame {frame}, {seconds:.4} s")
        }
        (Some(frame), Some(seconds)) => {
            format!("frame {frame}, {seconds:.4} s; the program has not drawn the last one yet")
        }
        _ => "the program has drawn no frame yet".to_owned(),
    }
}
