//! The program's side.

use super::layout::{
    self, ENDED, EXPECTED, FREE, Format, OPEN, READERS, REPLACED, ReaderWords, Stamp, header, picture, set, slot, value,
};
use crate::error::{Error, ErrorKind, Result};
use crate::system::SharedMemory;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering, fence};
use std::time::{Duration, Instant};

/// Smallest number of slots. With fewer, readers would lose frames that they have just begun to
/// copy.
pub const LEAST_SLOTS: usize = 3;

/// Alpha 255 of two pixels, as a word.
const OPAQUE: u64 = u64::from_ne_bytes([0, 0, 0, 255, 0, 0, 0, 255]);
/// Alpha of one pixel of 16 bits in a word.
const OPAQUE_DEEP: u64 = u64::from_ne_bytes([0, 0, 0, 0, 0, 0, 255, 255]);

/// Interval at which a waiting writer checks whether its readers are still alive.
const LOOK: Duration = Duration::from_millis(100);

/// Name and size of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Name of the output; only its first 64 bytes are written.
    pub name: String,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Format of its pixels.
    pub format: Format,
}

/// Publishes the frames of this program.
pub struct Writer {
    memory: SharedMemory,
    path: PathBuf,
    shapes: Vec<Shape>,
    /// First word of each picture's pixels, from its slot's first.
    pixels: Vec<usize>,
    slots: usize,
    slot_words: usize,
    waits: bool,
    number: u64,
    /// Number of frames that readers lost.
    lost: u64,
    /// The file before this one, while some of its readers have not come to this one.
    before: Option<SharedMemory>,
}

impl Writer {
    /// Makes a file for frames of these pictures in `slots` slots (at least 3). An older file of a
    /// program that has ended is replaced. `waits`: [`Writer::publish`] waits until the readers
    /// have copied what it overwrites.
    ///
    /// # Errors
    /// A file of this name exists that is not Cupola's, or whose writer is alive; there are too
    /// many pictures; or an error of the system.
    pub fn create(path: &Path, shapes: &[Shape], slots: usize, waits: bool) -> Result<Self> {
        let failed = |error: io::Error| Error::new(ErrorKind::Io, format!("{}: {error}", path.display()));
        match SharedMemory::open(path) {
            Ok(old) if value(&old, 0) != layout::MAGIC || old.words().len() < layout::FIRST_SLOT => {
                return Err(failed(io::Error::other("the file exists, and is not one of published frames")));
            }
            Ok(old) if old.is_locked(header::WRITER_LOCK * 8) => {
                return Err(failed(io::Error::other("another program publishes its frames there")));
            }
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(failed(error)),
        }
        Self::make(path, shapes, slots.max(LEAST_SLOTS), waits, None).map_err(failed)
    }

    /// Makes the file under another name and then renames it, so that readers never see half of it.
    /// Readers of `old` have an entry in it.
    fn make(path: &Path, shapes: &[Shape], slots: usize, waits: bool, old: Option<&Self>) -> io::Result<Self> {
        let number = old.map_or(0, |old| old.number);
        if shapes.len() > layout::PICTURES {
            return Err(io::Error::other(format!("at most {} pictures can be published", layout::PICTURES)));
        }
        let too_large = || io::Error::other("the pictures are too large to be published");
        let (mut pixels, mut slot_words) = (Vec::new(), layout::SLOT_HEAD);
        for shape in shapes {
            pixels.push(slot_words);
            let words = layout::pixel_words(shape.size, shape.format).ok_or_else(too_large)?;
            slot_words = slot_words.checked_add(words).ok_or_else(too_large)?;
        }
        let words = slot_words.checked_mul(slots).and_then(|words| words.checked_add(layout::FIRST_SLOT));
        let bytes = words.and_then(|words| words.checked_mul(8)).ok_or_else(too_large)?;
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".{}", std::process::id()));
        // A process of the same number may have left a file behind.
        let _ = std::fs::remove_file(&name);
        let memory = SharedMemory::create(name.as_ref(), bytes)?;
        memory.lock(header::WRITER_LOCK * 8);
        for (word, value) in [
            (header::VERSION, layout::VERSION),
            (header::SLOTS, slots as u64),
            (header::SLOT_WORDS, slot_words as u64),
            (header::FIRST_SLOT, layout::FIRST_SLOT as u64),
            (header::PUBLISHED, number),
            (header::STATE, OPEN),
            (header::WAITS, waits.into()),
            (header::PROCESS, std::process::id().into()),
            (header::MAGIC, layout::MAGIC),
        ] {
            set(&memory, word, value);
        }
        let mut writer = Self {
            memory,
            path: path.to_owned(),
            shapes: shapes.to_vec(),
            pixels,
            slots,
            slot_words,
            waits,
            number,
            lost: old.map_or(0, |old| old.lost),
            before: None,
        };
        (0..slots).for_each(|number| writer.write_table(writer.slot(number as u64)));
        if let Some(old) = old {
            writer.lost += (0..READERS).map(|reader| old.hand_over(&writer.memory, reader)).sum::<u64>();
        }
        std::fs::rename(&name, path).inspect_err(|_| drop(std::fs::remove_file(&name)))?;
        Ok(writer)
    }

    /// Gives a reader its entry in the next file. Returns the number of frames that it loses: if it
    /// never opened this file, all that lie in it.
    fn hand_over(&self, next: &SharedMemory, number: usize) -> u64 {
        let (from, to) = (ReaderWords::new(&self.memory, number), ReaderWords::new(next, number));
        let state = from.is_active().load(Ordering::Acquire);
        let mut lost = 0;
        if state == EXPECTED {
            lost = self.number.saturating_sub(from.cursor().load(Ordering::Acquire));
            to.lost().store(from.lost().load(Ordering::Relaxed) + lost, Ordering::Relaxed);
        }
        if state != FREE {
            to.cursor().store(self.number, Ordering::Relaxed);
            to.is_active().store(EXPECTED, Ordering::Release);
        }
        lost
    }

    fn write_table(&self, slot: usize) {
        set(&self.memory, slot + slot::PICTURES, self.shapes.len() as u64);
        for (number, (shape, pixels)) in self.shapes.iter().zip(&self.pixels).enumerate() {
            let entry = slot + slot::TABLE + number * picture::WORDS;
            let end = shape.name.floor_char_boundary(layout::NAME_BYTES);
            self.memory.write(entry + picture::NAME, &shape.name.as_bytes()[..end]);
            set(&self.memory, entry + picture::PIXELS, *pixels as u64);
            set(&self.memory, entry + picture::WIDTH, shape.size.0.into());
            set(&self.memory, entry + picture::HEIGHT, shape.size.1.into());
            set(&self.memory, entry + picture::FORMAT, shape.format.number());
        }
    }

    /// First word of the slot of frame `number`.
    fn slot(&self, number: u64) -> usize {
        layout::FIRST_SLOT + (number % self.slots as u64) as usize * self.slot_words
    }

    /// The pictures of a frame.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Number of frames that were published.
    pub fn published(&self) -> u64 {
        self.number
    }

    /// Publishes pictures of other names and sizes from now on, in a new file of the same name.
    /// Readers of the old file find it.
    ///
    /// # Errors
    /// Errors of the system; the old file stays then.
    pub fn reshape(&mut self, shapes: &[Shape]) -> Result<()> {
        if self.waits {
            // A reader opens the newest file: those of the file before have to come to this one
            // first.
            self.wait_for_readers(None, |reader| reader.is_active().load(Ordering::Acquire) != EXPECTED);
        }
        let new = Self::make(&self.path, shapes, self.slots, self.waits, Some(self));
        let new = new.map_err(|error| Error::new(ErrorKind::Io, format!("{}: {error}", self.path.display())))?;
        let old = std::mem::replace(self, new);
        old.finish(REPLACED);
        self.before = Some(old.memory);
        Ok(())
    }

    /// Publishes a frame with these numbers; `fill` writes its pictures. Allocates nothing.
    pub fn publish(&mut self, stamp: Stamp, fill: impl FnOnce(&mut Pictures<'_>)) {
        let (number, slot) = (self.number, self.slot(self.number));
        fence(Ordering::SeqCst);
        if let Some(oldest) = (number + 1).checked_sub(self.slots as u64) {
            self.lost += (0..READERS).map(|reader| self.move_on(reader, oldest)).sum::<u64>();
        }
        let word = |word: usize| &self.memory.words()[slot + word];
        word(slot::SEQUENCE).store(2 * number + 1, Ordering::Relaxed);
        // The following writes are not seen before the number above.
        fence(Ordering::Release);
        word(slot::INDEX).store(stamp.index, Ordering::Relaxed);
        word(slot::TIME).store(stamp.time, Ordering::Relaxed);
        word(slot::RIG).store(stamp.rig, Ordering::Relaxed);
        fill(&mut Pictures { memory: &self.memory, slot, shapes: &self.shapes, pixels: &self.pixels });
        word(slot::SEQUENCE).store(2 * number + 2, Ordering::Release);
        self.number += 1;
        set(&self.memory, header::PUBLISHED, self.number);
        self.memory.wake(header::PUBLISHED);
    }

    /// Keeps a reader's cursor from pointing to a frame before `oldest`: waits for the reader, or
    /// moves its cursor. Returns the number of frames that it loses. If the reader ends meanwhile,
    /// the losses may be written to another reader's word. Cupola's readers therefore count by
    /// their cursor alone.
    fn move_on(&self, number: usize, oldest: u64) -> u64 {
        let reader = ReaderWords::new(&self.memory, number);
        loop {
            let taken = value(&self.memory, header::TAKEN);
            let cursor = reader.cursor().load(Ordering::Acquire);
            if reader.is_active().load(Ordering::Acquire) == FREE || cursor >= oldest {
                return 0;
            }
            if !self.is_alive(reader) {
                self.free(reader);
            } else if self.waits {
                self.memory.wait(header::TAKEN, taken as u32, LOOK);
            } else if replace(reader.cursor(), cursor, oldest) {
                reader.lost().fetch_add(oldest - cursor, Ordering::Relaxed);
                return oldest - cursor;
            }
        }
    }

    /// Frees the entry of a dead reader. The lock keeps out a reader that would take the entry
    /// meanwhile; one that has taken it already keeps it.
    fn free(&self, reader: ReaderWords<'_>) {
        if self.memory.lock(reader.lock_byte()) {
            reader.is_active().store(FREE, Ordering::Release);
            self.memory.unlock(reader.lock_byte());
        }
    }

    /// True if the process of a reader that uses its entry, or is expected there, is alive. A
    /// reader locks its next entry before it leaves the last one, so that in this order one of the
    /// locks is found.
    fn is_alive(&self, reader: ReaderWords<'_>) -> bool {
        let is_locked = |memory: &SharedMemory| memory.is_locked(reader.lock_byte());
        let is_expected = reader.is_active().load(Ordering::Acquire) == EXPECTED;
        (is_expected && self.before.as_ref().is_some_and(is_locked)) || is_locked(&self.memory)
    }

    /// Waits for the first reader, for about a minute. Returns whether it came. The limit is a
    /// number of waits of the system, because the program's clock may stand still.
    pub fn wait_for_a_reader(&self) -> bool {
        for _ in 0..600 {
            let taken = value(&self.memory, header::TAKEN);
            if self.readers().0 > 0 {
                return true;
            }
            self.memory.wait(header::TAKEN, taken as u32, LOOK);
        }
        false
    }

    /// Waits until each living reader has copied everything, for no longer than `limit`.
    pub fn drain(&self, limit: Duration) {
        self.wait_for_readers(Some(Instant::now() + limit), |reader| {
            reader.cursor().load(Ordering::Acquire) >= self.number
        });
    }

    /// Waits until `is_done` holds for each living reader, or until `end`.
    fn wait_for_readers(&self, end: Option<Instant>, is_done: impl Fn(ReaderWords<'_>) -> bool) {
        for number in 0..READERS {
            let reader = ReaderWords::new(&self.memory, number);
            loop {
                let taken = value(&self.memory, header::TAKEN);
                let left = end.map_or(LOOK, |end| end.saturating_duration_since(Instant::now()));
                let is_free = reader.is_active().load(Ordering::Acquire) == FREE;
                if is_free || is_done(reader) || !self.is_alive(reader) || left.is_zero() {
                    break;
                }
                self.memory.wait(header::TAKEN, taken as u32, left.min(LOOK));
            }
        }
    }

    /// Number of living readers, and number of frames that all readers lost so far.
    pub fn readers(&self) -> (usize, u64) {
        let readers = (0..READERS).map(|number| ReaderWords::new(&self.memory, number));
        (readers.filter(|reader| self.memory.is_locked(reader.lock_byte())).count(), self.lost)
    }

    /// True if a reader uses the file, or did until it died.
    pub fn has_readers(&self) -> bool {
        (0..READERS).any(|number| ReaderWords::new(&self.memory, number).is_active().load(Ordering::Acquire) != FREE)
    }

    /// True if a reader has read all frames that were published.
    pub fn is_awaited(&self) -> bool {
        (0..READERS).map(|number| ReaderWords::new(&self.memory, number)).any(|reader| {
            reader.is_active().load(Ordering::Acquire) != FREE && reader.cursor().load(Ordering::Acquire) >= self.number
        })
    }

    fn finish(&self, state: u64) {
        set(&self.memory, header::STATE, state);
        self.memory.wake(header::PUBLISHED);
    }

    /// Announces to readers that the program ends, and removes the file. If the program waits for
    /// its readers, those that still read the file before come to this one first. Does nothing in a
    /// copy of the process that `fork` made: the file is not its own.
    pub fn end(self) {
        if value(&self.memory, header::PROCESS) != u64::from(std::process::id()) {
            return;
        }
        if self.waits && self.before.is_some() {
            self.wait_for_readers(Some(Instant::now() + FOR_THE_LAST), |reader| {
                reader.is_active().load(Ordering::Acquire) != EXPECTED
            });
        }
        self.finish(ENDED);
        // The file may be gone already, which is no error.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Replaces `old` by `new` if the word is still `old`.
fn replace(word: &AtomicU64, old: u64, new: u64) -> bool {
    word.compare_exchange(old, new, Ordering::AcqRel, Ordering::Relaxed).is_ok()
}

/// Longest time that a program which ends waits for readers of its file before.
const FOR_THE_LAST: Duration = Duration::from_secs(5);

/// The pictures of the frame that is being written.
pub struct Pictures<'a> {
    memory: &'a SharedMemory,
    slot: usize,
    shapes: &'a [Shape],
    pixels: &'a [usize],
}

impl Pictures<'_> {
    /// First byte and number of bytes of picture `number`, for a driver that writes all of its pixels, alpha too. The
    /// memory stays while this lives.
    pub fn memory(&mut self, number: usize) -> Option<(*mut u8, usize)> {
        let (shape, pixels) = (self.shapes.get(number)?, self.pixels.get(number)?);
        let words = layout::pixel_words(shape.size, shape.format)?;
        let words = self.memory.words().get(self.slot + pixels..)?.get(..words)?;
        Some((words.as_ptr().cast_mut().cast(), size_of_val(words)))
    }

    /// Writes row `y`, counted from the top, of picture `number`, in its format. Alpha is written as
    /// the largest value. Rows that are not written stay as they were in an earlier frame. Pixels
    /// outside the picture are left out.
    pub fn row(&mut self, number: usize, y: u32, row: &[u8]) {
        let (Some(shape), Some(pixels)) = (self.shapes.get(number), self.pixels.get(number)) else { return };
        let (width, height) = (shape.size.0 as usize, shape.size.1);
        let row = &row[..row.len().min(width * shape.format.pixel_bytes())];
        if y >= height {
            return;
        }
        if shape.format == Format::Rgba16 {
            self.memory.write_or(self.slot + pixels + y as usize * width, row, OPAQUE_DEEP);
            return;
        }
        // Two pixels are one word, so that a row may begin in the middle of a word.
        let first = y as usize * width;
        let (half, rest) = row.split_at(if first % 2 == 1 { 4.min(row.len()) } else { 0 });
        let word = self.slot + pixels + first / 2;
        if let Some(pixel) = half.first_chunk::<4>() {
            let mut both = self.memory.words()[word].load(Ordering::Relaxed).to_ne_bytes();
            both[4..].copy_from_slice(pixel);
            self.memory.write_or(word, &both, OPAQUE);
        }
        self.memory.write_or(word + first % 2, rest, OPAQUE);
    }
}
