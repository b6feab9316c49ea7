//! The page that a program shares with its command.

use crate::error::{Error, ErrorKind, Result};
use crate::system::SharedMemory;
use std::io;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// First word of each page: `CUPONODE`.
const MAGIC: u64 = u64::from_ne_bytes(*b"CUPONODE");
/// Second word. It is equal only in releases whose pages are compatible.
const VERSION: u64 = 2;

/// Words of the page.
mod word {
    pub const MAGIC: usize = 0;
    pub const VERSION: usize = 1;
    /// Longest wait of the program, in nanoseconds.
    pub const LIMIT: usize = 2;
    /// Time from one frame to the next while the program goes on by itself, in nanoseconds.
    pub const LENGTH: usize = 3;
    /// Number of the frame whose end the program has reached, from 1. Its low half is a futex.
    pub const ARRIVED: usize = 8;
    /// Sum of the calls of that frame.
    pub const DIGEST: usize = 9;
    /// Time of the program after that frame.
    pub const TIME: usize = 10;
    /// Time at which the frame before it was released, on the machine's monotonic clock.
    pub const WENT: usize = 11;
    /// Width of the program's window times 2³², plus height.
    pub const SIZE: usize = 12;
    /// Number of the program's process, as the system counts them.
    pub const PROCESS: usize = 13;
    /// Number of the newest frame that the program may pass. Its low half is a futex.
    pub const RELEASED: usize = 16;
    /// Number of the newest frame that all may show.
    pub const NEWEST: usize = 17;
    /// The command holds a lock on the first byte of this word.
    pub const COMMAND_LOCK: usize = 24;
    /// Times of the program after the newest frames, by their number modulo [`super::TIMES`].
    pub const TIMES: usize = 64;
}

/// Number of frames for which the time after them is stored: those that a late program has yet to
/// draw.
const TIMES: u64 = 4096;

/// Size of a page in bytes.
const BYTES: usize = (word::TIMES + TIMES as usize) * size_of::<u64>();

/// Arrival of a program at the end of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Arrival {
    /// Number of the frame, from 1.
    pub frame: u64,
    /// Sum of the program's calls in it.
    pub digest: u64,
    /// Time of the program after it, in nanoseconds.
    pub time: u64,
    /// Time at which the frame before it was released, on the machine's monotonic clock, in
    /// nanoseconds.
    pub went: u64,
    /// Width and height of the program's window in pixels.
    pub size: (u32, u32),
}

/// Nanoseconds of a length, as far as they fit.
fn nanoseconds(length: Duration) -> u64 {
    u64::try_from(length.as_nanos()).unwrap_or(u64::MAX)
}

/// A page in shared memory.
pub struct Page(SharedMemory);

impl Page {
    /// Makes a page. A program waits at most `limit` for its command, and then shows a frame every
    /// `length`.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn create(path: &Path, limit: Duration, length: Duration) -> io::Result<Self> {
        let page = Self(SharedMemory::create(path, BYTES)?);
        page.0.lock(word::COMMAND_LOCK * 8);
        page.set(word::LIMIT, nanoseconds(limit));
        page.set_length(length);
        page.set(word::VERSION, VERSION);
        page.set(word::MAGIC, MAGIC);
        Ok(page)
    }

    /// Opens the page that a command has made.
    ///
    /// # Errors
    /// Errors of the system, or the file is no page of this release.
    pub fn open(path: &Path) -> Result<Self> {
        let failed = |error: io::Error| Error::new(ErrorKind::Io, format!("{}: {error}", path.display()));
        let page = Self(SharedMemory::open(path).map_err(failed)?);
        if page.0.words().len() * size_of::<u64>() < BYTES
            || page.get(word::MAGIC) != MAGIC
            || page.get(word::VERSION) != VERSION
        {
            return Err(failed(io::Error::other("the file is no page of this release of cupola node")));
        }
        Ok(page)
    }

    fn get(&self, word: usize) -> u64 {
        self.0.words()[word].load(Ordering::Acquire)
    }

    fn set(&self, word: usize, value: u64) {
        self.0.words()[word].store(value, Ordering::Release);
    }

    /// Longest wait of the program.
    pub fn limit(&self) -> Duration {
        Duration::from_nanos(self.get(word::LIMIT))
    }

    /// Time from one frame to the next while the program goes on by itself.
    pub fn length(&self) -> Duration {
        Duration::from_nanos(self.get(word::LENGTH))
    }

    /// Sets the time of [`Page::length`]. The program does not run yet.
    pub fn set_length(&self, length: Duration) {
        self.set(word::LENGTH, nanoseconds(length));
    }

    /// Records that the program that will arrive here is this process.
    pub fn take(&self) {
        self.set(word::PROCESS, std::process::id().into());
    }

    /// Number of the program's process; 0 before it has opened the page.
    pub fn process(&self) -> u32 {
        self.get(word::PROCESS) as u32
    }

    /// Announces that the program has reached the end of a frame. Only the program calls it.
    pub fn arrive(&self, arrival: &Arrival) {
        let Arrival { frame, digest, time, went, size: (width, height) } = *arrival;
        self.set(word::DIGEST, digest);
        self.set(word::TIME, time);
        self.set(word::WENT, went);
        self.set(word::SIZE, u64::from(width) << 32 | u64::from(height));
        self.set(word::ARRIVED, frame);
        self.0.wake(word::ARRIVED);
    }

    /// Newest arrival of the program, if its frame is not `known`; waits for it no longer than
    /// `limit`. A program that does not wait may overwrite the numbers meanwhile. They then mix two
    /// frames, and `None` is returned.
    pub fn arrival(&self, known: u64, limit: Duration) -> Option<Arrival> {
        let mut frame = self.get(word::ARRIVED);
        if frame == known {
            self.0.wait(word::ARRIVED, known as u32, limit);
            frame = self.get(word::ARRIVED);
        }
        let size = self.get(word::SIZE);
        let arrival = Arrival {
            frame,
            digest: self.get(word::DIGEST),
            time: self.get(word::TIME),
            went: self.get(word::WENT),
            size: ((size >> 32) as u32, size as u32),
        };
        (frame != known && self.get(word::ARRIVED) == frame).then_some(arrival)
    }

    /// Number of the frame whose end the program has reached.
    pub fn arrived(&self) -> u64 {
        self.get(word::ARRIVED)
    }

    /// Number of the newest frame that the program may pass.
    pub fn released(&self) -> u64 {
        self.get(word::RELEASED)
    }

    /// Number of the newest frame that all may show.
    pub fn newest(&self) -> u64 {
        self.get(word::NEWEST)
    }

    /// Announces that all may show frames up to this number; `time` is the program's time after the
    /// last of them. This program does not pass them yet.
    pub fn announce(&self, frame: u64, time: u64) {
        if frame > self.newest() {
            self.set(word::TIMES + (frame % TIMES) as usize, time);
            self.set(word::NEWEST, frame);
        }
    }

    /// The program may pass frames up to this number.
    pub fn release(&self, frame: u64) {
        if frame > self.released() {
            self.set(word::RELEASED, frame);
            self.0.wake(word::RELEASED);
        }
    }

    /// Time of the program after a frame, if the command has set one.
    pub fn time_after(&self, frame: u64) -> Option<u64> {
        let time = self.get(word::TIMES + (frame % TIMES) as usize);
        (time != 0 && frame + TIMES > self.newest()).then_some(time)
    }

    /// Waits until the program may pass more than `released` frames, for no longer than `limit`.
    pub fn wait_for_more(&self, released: u64, limit: Duration) {
        self.0.wait(word::RELEASED, released as u32, limit);
    }

    /// Releases the program for good, as if the command had ended.
    pub fn leave(&self) {
        self.0.unlock(word::COMMAND_LOCK * 8);
    }

    /// True if the command is alive.
    pub fn has_command(&self) -> bool {
        self.0.is_locked(word::COMMAND_LOCK * 8)
    }
}
