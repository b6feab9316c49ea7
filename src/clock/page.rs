//! Page by which another process holds the program's time. Both sides compile this file: the
//! library of the clock, and `cupola`.

#![allow(dead_code, reason = "each side uses a part")]

use std::sync::atomic::{AtomicU64, Ordering};

/// Number of words of 64 bits.
pub const WORDS: usize = 8;
/// Value of [`MAGIC`].
pub const IS_PAGE: u64 = u64::from_ne_bytes(*b"CUPCLOCK");
/// Value of [`UNTIL`] while the time is not held.
pub const NEVER: u64 = u64::MAX;

/// [`IS_PAGE`] with the version of the layout added.
const MAGIC: usize = 0;
/// Frame of the display beyond which the time does not go, or [`NEVER`].
const UNTIL: usize = 1;
/// Current frame of the display.
const FRAME: usize = 2;
/// Frame of the display whose picture was complete last, plus 1.
const COMPLETE: usize = 3;
/// Process whose time it is; 0 before its first frame is complete.
const PROCESS: usize = 4;
/// Frames per [`SECONDS`].
const FRAMES: usize = 5;
/// See [`FRAMES`].
const SECONDS: usize = 6;
/// Version of this layout.
const VERSION: u64 = 1;

/// The page's words.
#[derive(Clone, Copy)]
pub struct Page<'a>(&'a [AtomicU64]);

impl<'a> Page<'a> {
    /// `None` if these are not the words of a page.
    pub fn new(words: &'a [AtomicU64]) -> Option<Self> {
        let is_page = words.len() >= WORDS && words[MAGIC].load(Ordering::Acquire) == IS_PAGE.wrapping_add(VERSION);
        is_page.then_some(Self(words))
    }

    /// Writes a new page to words that are 0. `holds`: the time is held from the first frame on.
    pub fn begin(words: &'a [AtomicU64], (frames, seconds): (u64, u64), holds: bool) {
        words[UNTIL].store(if holds { 0 } else { NEVER }, Ordering::Relaxed);
        words[FRAMES].store(frames, Ordering::Relaxed);
        words[SECONDS].store(seconds, Ordering::Relaxed);
        words[MAGIC].store(IS_PAGE.wrapping_add(VERSION), Ordering::Release);
    }

    fn word(self, word: usize) -> u64 {
        self.0[word].load(Ordering::Acquire)
    }

    /// Makes this process the one whose time it is. `is_gone`: tells whether a process has ended.
    pub fn claim(self, process: u64, is_gone: impl Fn(u64) -> bool) -> bool {
        let before = self.word(PROCESS);
        if before == process {
            return true;
        }
        let is_free = before == 0 || is_gone(before);
        is_free && self.0[PROCESS].compare_exchange(before, process, Ordering::AcqRel, Ordering::Relaxed).is_ok()
    }

    /// Frame beyond which the time does not go, or [`NEVER`].
    pub fn until(self) -> u64 {
        self.word(UNTIL)
    }

    /// Notes that the picture of frame `complete` is complete, and that `next` is the current one.
    pub fn pass(self, complete: u64, next: u64) {
        self.0[COMPLETE].store(complete + 1, Ordering::Release);
        self.0[FRAME].store(next, Ordering::Release);
    }

    /// Holds the time at the current frame.
    pub fn hold(self) {
        self.0[UNTIL].store(self.word(FRAME), Ordering::Release);
    }

    /// Lets the time go on.
    pub fn release(self) {
        self.0[UNTIL].store(NEVER, Ordering::Release);
    }

    /// Lets the time go on by this number of frames. Time that is not held is held first.
    pub fn step(self, frames: u64) {
        let update = |until: u64| {
            let from = if until == NEVER { self.word(FRAME) } else { until.max(self.word(FRAME)) };
            Some(from.saturating_add(frames).min(NEVER - 1))
        };
        // The update always has a value.
        let _ = self.0[UNTIL].fetch_update(Ordering::AcqRel, Ordering::Acquire, update);
    }

    /// Frame whose picture was complete last; `None` before the first.
    pub fn complete(self) -> Option<u64> {
        self.word(COMPLETE).checked_sub(1)
    }

    /// True if the time is held, and the picture of the frame at which it stands is complete.
    pub fn stands(self) -> bool {
        let until = self.until();
        until != NEVER && self.complete().is_some_and(|complete| complete >= until)
    }

    /// The program's time at the beginning of the frame, in seconds.
    pub fn seconds(self, frame: u64) -> f64 {
        frame as f64 * self.word(SECONDS) as f64 / self.word(FRAMES).max(1) as f64
    }
}
