//! Layout of the file. Numbers are words of 64 bits in the machine's byte order; positions count
//! words.

use crate::system::SharedMemory;
use std::sync::atomic::{AtomicU64, Ordering};

/// First word of each file: `CUPORING`.
pub const MAGIC: u64 = u64::from_ne_bytes(*b"CUPORING");
/// Second word. It grows when the layout changes, so that older readers fail.
pub const VERSION: u64 = 1;

/// Words of the header.
pub mod header {
    /// [`MAGIC`](super::MAGIC).
    pub const MAGIC: usize = 0;
    /// [`VERSION`](super::VERSION).
    pub const VERSION: usize = 1;
    /// Number of slots.
    pub const SLOTS: usize = 2;
    /// Words of a slot.
    pub const SLOT_WORDS: usize = 3;
    /// First word of the first slot.
    pub const FIRST_SLOT: usize = 4;
    /// Number of frames that were published. Its low half is a futex.
    pub const PUBLISHED: usize = 5;
    /// State of the file: [`OPEN`](super::OPEN), [`REPLACED`](super::REPLACED) or
    /// [`ENDED`](super::ENDED).
    pub const STATE: usize = 6;
    /// 1: the writer waits for its readers.
    pub const WAITS: usize = 7;
    /// Grows when a reader advances its cursor. Its low half is a futex.
    pub const TAKEN: usize = 8;
    /// Number of the writer's process.
    pub const PROCESS: usize = 9;
    /// The writer holds a lock on the first byte of this word.
    pub const WRITER_LOCK: usize = 10;
}

/// The writer publishes in this file.
pub const OPEN: u64 = 0;
/// The pictures have changed, and another file of the same name has replaced this one.
pub const REPLACED: u64 = 1;
/// The program has ended.
pub const ENDED: u64 = 2;

/// No reader uses this entry.
pub const FREE: u64 = 0;
/// A reader uses this entry.
pub const ACTIVE: u64 = 1;
/// A reader of the file before this one will use this entry.
pub const EXPECTED: u64 = 2;

/// Readers that one file can have.
pub const READERS: usize = 16;
/// First word of the first reader.
const FIRST_READER: usize = 64;
/// Words of a reader.
const READER_WORDS: usize = 8;

/// Words of a reader, from its first.
mod reader {
    pub const IS_ACTIVE: usize = 0;
    pub const CURSOR: usize = 1;
    pub const LOST: usize = 2;
}

/// Words of a slot, from its first.
pub mod slot {
    /// 2k+1 while frame k is written, 2k+2 when it is complete.
    pub const SEQUENCE: usize = 0;
    /// The program's own number of the frame, from 1.
    pub const INDEX: usize = 1;
    /// Time of the frame, in nanoseconds of the system's monotonic clock.
    pub const TIME: usize = 2;
    /// Number of pictures.
    pub const PICTURES: usize = 3;
    /// Checksum of the rig that the frame shows, or 0: [`Stamp::rig`](super::Stamp::rig).
    pub const RIG: usize = 4;
    /// First word of the table of pictures.
    pub const TABLE: usize = 8;
}

/// Words of a picture in the table, from its first.
pub mod picture {
    /// Its name, in UTF-8, filled with zeroes.
    pub const NAME: usize = 0;
    /// Its first pixel, in words from the slot's first.
    pub const PIXELS: usize = 8;
    /// Its width in pixels.
    pub const WIDTH: usize = 9;
    /// Its height in pixels.
    pub const HEIGHT: usize = 10;
    /// Its format: the number of a [`Format`](super::Format).
    pub const FORMAT: usize = 11;
    /// Words of a picture.
    pub const WORDS: usize = 16;
}

/// Numbers of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamp {
    /// The program's own number of the frame, from 1.
    pub index: u64,
    /// Time on the program's monotonic clock, in nanoseconds.
    pub time: u64,
    /// Checksum of the text of the rig's file that the frame shows ([`text_sum`]); 0: not known.
    pub rig: u64,
}

/// Checksum of the text of a rig's file: FNV-1a with 64 bits. It is never 0.
pub fn text_sum(text: &[u8]) -> u64 {
    let sum = text
        .iter()
        .fold(0xCBF2_9CE4_8422_2325, |sum: u64, byte| (sum ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3));
    sum.max(1)
}

/// Bytes of a name.
pub const NAME_BYTES: usize = 64;
/// Pictures that a frame can have.
pub const PICTURES: usize = 64;
/// Format of a picture's pixels: red first, values as they are displayed, rows from the top without
/// gaps, alpha is the largest value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Four bytes for each pixel.
    #[default]
    Rgba8,
    /// Four numbers of 16 bits for each pixel, in the machine's byte order.
    Rgba16,
}

impl Format {
    /// Its number in the file.
    pub const fn number(self) -> u64 {
        match self {
            Self::Rgba8 => 1,
            Self::Rgba16 => 2,
        }
    }

    /// Format with this number.
    pub fn of(number: u64) -> Option<Self> {
        [Self::Rgba8, Self::Rgba16].into_iter().find(|format| format.number() == number)
    }

    /// Bytes of a pixel.
    pub const fn pixel_bytes(self) -> usize {
        match self {
            Self::Rgba8 => 4,
            Self::Rgba16 => 8,
        }
    }
}

/// Pixels begin at whole pages.
const PAGE_WORDS: usize = 512;
/// Words of a slot in front of its pixels.
pub const SLOT_HEAD: usize = (slot::TABLE + PICTURES * picture::WORDS).next_multiple_of(PAGE_WORDS);
/// First word of the first slot.
pub const FIRST_SLOT: usize = (FIRST_READER + READERS * READER_WORDS).next_multiple_of(PAGE_WORDS);

/// Number of words of a picture's pixels; `None` if they do not fit into memory.
pub fn pixel_words((width, height): (u32, u32), format: Format) -> Option<usize> {
    let pixels = (width as usize).checked_mul(height as usize)?;
    Some(pixels.checked_mul(format.pixel_bytes())?.div_ceil(8).next_multiple_of(8))
}

/// Words of a reader in the file.
#[derive(Clone, Copy)]
pub struct ReaderWords<'a> {
    memory: &'a SharedMemory,
    first: usize,
}

impl<'a> ReaderWords<'a> {
    /// Words of the reader with this number, below [`READERS`].
    pub fn new(memory: &'a SharedMemory, number: usize) -> Self {
        Self { memory, first: FIRST_READER + number * READER_WORDS }
    }

    /// Byte of the file on which the reader holds a lock.
    pub fn lock_byte(self) -> usize {
        self.first * size_of::<u64>()
    }

    /// [`FREE`], [`ACTIVE`] or [`EXPECTED`].
    pub fn is_active(self) -> &'a AtomicU64 {
        &self.memory.words()[self.first + reader::IS_ACTIVE]
    }

    /// Number of the frame that the reader copies next.
    pub fn cursor(self) -> &'a AtomicU64 {
        &self.memory.words()[self.first + reader::CURSOR]
    }

    /// Number of frames that the reader lost.
    pub fn lost(self) -> &'a AtomicU64 {
        &self.memory.words()[self.first + reader::LOST]
    }
}

/// The value of a word.
pub fn value(memory: &SharedMemory, word: usize) -> u64 {
    memory.words()[word].load(Ordering::Acquire)
}

/// Sets a word.
pub fn set(memory: &SharedMemory, word: usize, value: u64) {
    memory.words()[word].store(value, Ordering::Release);
}
