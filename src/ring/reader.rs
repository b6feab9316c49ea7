//! The side of readers: `cupola record` and others.

use super::layout::{
    self, ACTIVE, ENDED, EXPECTED, FREE, Format, OPEN, READERS, REPLACED, ReaderWords, header, picture, set, slot,
    value,
};
use crate::error::{Error, ErrorKind, Result};
use crate::system::SharedMemory;
use std::path::{Path, PathBuf};
use std::sync::atomic::{Ordering, fence};
use std::time::{Duration, Instant};

/// Interval at which a waiting reader checks whether the writer is still alive.
const LOOK: Duration = Duration::from_millis(100);

/// Reads the frames that a program publishes.
pub struct Reader {
    memory: SharedMemory,
    path: PathBuf,
    /// Number of this reader's entry in the file.
    entry: usize,
    shape: FileShape,
    /// Number of the frame after the last one that was copied or skipped. Those between it and the
    /// cursor are lost.
    next: u64,
    /// Number of frames that were lost before it.
    lost: u64,
    /// True if it also takes pictures of 16 bits.
    takes_deep: bool,
}

/// Numbers of the header, checked against the size of the file.
#[derive(Clone, Copy)]
struct FileShape {
    slots: u64,
    slot_words: usize,
    first_slot: usize,
}

/// A picture of a frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    /// Name of the output.
    pub name: String,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Its pixels, red first, rows from the top.
    pub rgba: Vec<u8>,
    /// Format of the pixels: [`Format::Rgba8`], unless the reader asked for others.
    pub format: Format,
}

/// A frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Frame {
    /// Number in the ring, from 0, without gaps.
    pub number: u64,
    /// Number that the program gave it, from 1.
    pub index: u64,
    /// Time on the monotonic clock, in nanoseconds.
    pub time: u64,
    /// Checksum of the rig that it shows; 0: not known.
    pub rig: u64,
    /// Its pictures.
    pub pictures: Vec<Picture>,
}

/// Result of waiting for a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// A frame was copied.
    Frame,
    /// No frame came in time.
    Nothing,
    /// The program has ended, and every frame was read.
    Ended,
}

impl Reader {
    /// Opens the file of a program that publishes its frames. The first frame will be the next one
    /// that is published.
    ///
    /// # Errors
    /// There is no such file, it is no file of published frames, or it has 16 readers already.
    pub fn open(path: &Path) -> Result<Self> {
        Self::begin(path, None)
    }

    /// Like [`Reader::open`], but the first frame will be the newest one that is published already,
    /// if there is one. So a reader also shows a program that draws no more frames.
    ///
    /// # Errors
    /// As of [`Reader::open`].
    pub fn open_at_newest(path: &Path) -> Result<Self> {
        let mut reader = Self::begin(path, None)?;
        let published = value(&reader.memory, header::PUBLISHED);
        let newest = published.saturating_sub(1);
        let cursor = reader.words().cursor();
        if cursor.compare_exchange(published, newest, Ordering::AcqRel, Ordering::Relaxed).is_ok() {
            reader.next = newest;
            // The writer may not have seen the cursor before it used the slot again: then there are
            // newer frames. It has the same fence.
            fence(Ordering::SeqCst);
            if value(&reader.memory, header::PUBLISHED) > published {
                let moved = reader.words().cursor().fetch_max(published, Ordering::AcqRel) > newest;
                // The writer counts the frames before a cursor that it has moved as lost.
                reader.next = if moved { newest } else { published };
            }
        }
        Ok(reader)
    }

    /// Also takes pictures with 16 bits for each colour. Other readers refuse them.
    #[must_use]
    pub fn taking_deep(mut self) -> Self {
        self.takes_deep = true;
        self
    }

    /// `before`: entry in the previous file, and number of the next frame.
    fn begin(path: &Path, before: Option<(usize, u64)>) -> Result<Self> {
        let failed = |text: String| Error::new(ErrorKind::Io, format!("{}: {text}", path.display()));
        let memory = SharedMemory::open(path).map_err(|error| failed(error.to_string()))?;
        let shape = FileShape::of(&memory).map_err(|text| failed(text.to_owned()))?;
        let state = |number: usize| ReaderWords::new(&memory, number).is_active().load(Ordering::Acquire);
        let lock = |number: &usize| memory.lock(ReaderWords::new(&memory, *number).lock_byte());
        let own = before.map(|(entry, _)| entry).filter(|entry| state(*entry) == EXPECTED).filter(lock);
        let free = || (0..READERS).find(|number| state(*number) != EXPECTED && lock(number));
        let Some(entry) = own.or_else(free) else {
            return Err(failed(format!("{READERS} readers read these frames already")));
        };
        let words = ReaderWords::new(&memory, entry);
        if own.is_none() {
            words.is_active().store(FREE, Ordering::Release);
            words.lost().store(0, Ordering::Relaxed);
            words.cursor().store(value(&memory, header::PUBLISHED), Ordering::Release);
        }
        words.is_active().store(ACTIVE, Ordering::Release);
        if own.is_none() {
            // Frames that came meanwhile were not counted for this reader. The writer has the same
            // fence: either the writer sees that the entry is used, or its frame is seen here.
            fence(Ordering::SeqCst);
            words.cursor().fetch_max(value(&memory, header::PUBLISHED), Ordering::AcqRel);
        }
        let next = before.map_or_else(|| words.cursor().load(Ordering::Acquire), |(_, next)| next);
        // A writer may wait for its first reader.
        memory.words()[header::TAKEN].fetch_add(1, Ordering::Release);
        memory.wake(header::TAKEN);
        Ok(Self { path: path.to_owned(), entry, shape, next, lost: 0, takes_deep: false, memory })
    }

    fn words(&self) -> ReaderWords<'_> {
        ReaderWords::new(&self.memory, self.entry)
    }

    /// Number of frames that this reader lost because it was too slow.
    pub fn lost(&self) -> u64 {
        self.lost + self.words().cursor().load(Ordering::Acquire).saturating_sub(self.next)
    }

    /// Waits for the next frame, no longer than `limit`, and copies it to `frame`.
    ///
    /// # Errors
    /// The file is damaged, or its successor cannot be opened.
    pub fn next(&mut self, limit: Duration, frame: &mut Frame) -> Result<Next> {
        let end = Instant::now() + limit;
        loop {
            let published = value(&self.memory, header::PUBLISHED);
            let cursor = self.words().cursor().load(Ordering::Acquire);
            if cursor < published {
                if self.copy(cursor, frame)? {
                    self.go_on(cursor, cursor + 1);
                    return Ok(Next::Frame);
                }
                continue;
            }
            match value(&self.memory, header::STATE) {
                // Frames that were published before the end are still read.
                _ if value(&self.memory, header::PUBLISHED) > cursor => continue,
                OPEN => {}
                // The program has removed the next file meanwhile: it ended.
                REPLACED if !self.path.exists() => return Ok(Next::Ended),
                REPLACED => {
                    self.follow()?;
                    continue;
                }
                _ => return Ok(Next::Ended),
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(Next::Nothing);
            }
            self.memory.wait(header::PUBLISHED, published as u32, left.min(LOOK));
            let is_unchanged = value(&self.memory, header::PUBLISHED) == published;
            if is_unchanged && !self.memory.is_locked(header::WRITER_LOCK * 8) {
                // The writer died without announcing the end.
                if value(&self.memory, header::STATE) == OPEN {
                    set(&self.memory, header::STATE, ENDED);
                }
            }
        }
    }

    /// Skips all frames before the newest one, without counting them as lost.
    pub fn skip_to_newest(&mut self) {
        let newest = value(&self.memory, header::PUBLISHED).saturating_sub(1);
        // Meanwhile only the writer may have moved the cursor, and only forward.
        let cursor = self.words().cursor().fetch_max(newest, Ordering::AcqRel);
        self.go_on(cursor, cursor.max(newest));
    }

    /// Updates the counts after the cursor moved from `cursor` to `next`.
    fn go_on(&mut self, cursor: u64, next: u64) {
        self.lost += cursor.saturating_sub(self.next);
        self.next = next;
    }

    /// Continues with the file that replaced this one.
    fn follow(&mut self) -> Result<()> {
        let mut next = Self::begin(&self.path, Some((self.entry, self.next)))?;
        (next.lost, next.takes_deep) = (self.lost, self.takes_deep);
        *self = next;
        Ok(())
    }

    /// Copies frame `number`. Returns whether it was still there.
    fn copy(&self, number: u64, frame: &mut Frame) -> Result<bool> {
        let slot = self.shape.first_slot + (number % self.shape.slots) as usize * self.shape.slot_words;
        let word = |word: usize| self.memory.words()[slot + word].load(Ordering::Relaxed);
        let is_whole = || self.memory.words()[slot + slot::SEQUENCE].load(Ordering::Acquire) == 2 * number + 2;
        let was_whole = is_whole();
        if was_whole {
            (frame.number, frame.index, frame.time) = (number, word(slot::INDEX), word(slot::TIME));
            frame.rig = word(slot::RIG);
            self.copy_pictures(slot, frame)?;
        }
        // The copy is complete before the cursor moves.
        fence(Ordering::Acquire);
        let moved =
            self.words().cursor().compare_exchange(number, number + 1, Ordering::AcqRel, Ordering::Relaxed).is_ok();
        if moved {
            self.memory.words()[header::TAKEN].fetch_add(1, Ordering::Release);
            self.memory.wake(header::TAKEN);
            // From here on the writer may use the slot again.
            if !was_whole {
                return Err(self.damaged());
            }
        }
        Ok(moved)
    }

    fn copy_pictures(&self, slot: usize, frame: &mut Frame) -> Result<()> {
        let word = |word: usize| self.memory.words()[slot + word].load(Ordering::Relaxed);
        let count = word(slot::PICTURES) as usize;
        if count > layout::PICTURES {
            return Err(self.damaged());
        }
        frame.pictures.resize_with(count, Picture::default);
        for (number, copy) in frame.pictures.iter_mut().enumerate() {
            let entry = slot::TABLE + number * picture::WORDS;
            let side = |at: usize| u32::try_from(word(entry + at)).ok();
            let pixels = word(entry + picture::PIXELS) as usize;
            let size = side(picture::WIDTH).zip(side(picture::HEIGHT));
            let format = self.format(word(entry + picture::FORMAT))?;
            let words = size.and_then(|size| layout::pixel_words(size, format));
            let fits =
                words.and_then(|words| words.checked_add(pixels)).is_some_and(|end| end <= self.shape.slot_words);
            let (Some(size), true) = (size, fits) else {
                return Err(self.damaged());
            };
            let mut name = [0; layout::NAME_BYTES];
            self.memory.read(slot + entry + picture::NAME, &mut name);
            let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
            let name = String::from_utf8_lossy(&name[..end]);
            if copy.name != name {
                copy.name = name.into_owned();
            }
            (copy.size, copy.format) = (size, format);
            copy.rgba.resize(size.0 as usize * size.1 as usize * format.pixel_bytes(), 0);
            self.memory.read(slot + pixels, &mut copy.rgba);
        }
        Ok(())
    }

    fn format(&self, number: u64) -> Result<Format> {
        let refused = |text: String| Error::new(ErrorKind::Io, format!("{}: {text}", self.path.display()));
        match Format::of(number) {
            Some(Format::Rgba16) if !self.takes_deep => Err(refused(
                "these frames have 16 bits for each colour, which only cupola record takes; publish them without \
                 CUPOLA_PUBLISH_DEPTH=16"
                    .to_owned(),
            )),
            Some(format) => Ok(format),
            None => Err(refused(format!(
                "the pixels have the format {number}, which this version of Cupola does not know; use the version that \
                 the program runs with"
            ))),
        }
    }

    fn damaged(&self) -> Error {
        Error::new(ErrorKind::Io, format!("{}: the file of published frames is damaged", self.path.display()))
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        self.words().is_active().store(FREE, Ordering::Release);
        self.memory.unlock(self.words().lock_byte());
        self.memory.words()[header::TAKEN].fetch_add(1, Ordering::Release);
        self.memory.wake(header::TAKEN);
    }
}

impl FileShape {
    fn of(memory: &SharedMemory) -> std::result::Result<Self, &'static str> {
        let word = |word: usize| memory.words().get(word).map_or(0, |word| word.load(Ordering::Acquire));
        if word(header::MAGIC) != layout::MAGIC {
            return Err("this is no file of published frames");
        }
        if word(header::VERSION) != layout::VERSION {
            return Err("another version of Cupola publishes these frames");
        }
        let number = |at: usize| usize::try_from(word(at)).ok();
        let shape = || {
            let (slots, slot_words, first_slot) =
                (number(header::SLOTS)?, number(header::SLOT_WORDS)?, number(header::FIRST_SLOT)?);
            let end = slots.checked_mul(slot_words)?.checked_add(first_slot)?;
            let is_right = slots > 0 && slot_words >= layout::SLOT_HEAD && first_slot >= layout::FIRST_SLOT;
            (is_right && end <= memory.words().len()).then_some(Self { slots: slots as u64, slot_words, first_slot })
        };
        shape().ok_or("the file of published frames is damaged")
    }
}
