//! Compares the numbers of `include/cupola_ring.h` with those of [`layout`].

use super::layout::{self, Format, ReaderWords, header, picture, slot};
use crate::system::SharedMemory;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicU64;

const TEXT: &str = include_str!("../../include/cupola_ring.h");

/// Names and values of the header.
fn defined(text: &str) -> BTreeMap<String, String> {
    let lines = text.lines().filter_map(|line| line.strip_prefix("#define CUPOLA_RING_")?.split_once(' '));
    lines.map(|(name, value)| (name.to_owned(), value.to_owned())).collect()
}

/// Names and values of the sources.
fn expected() -> BTreeMap<String, String> {
    let path = std::env::temp_dir().join(format!("cupola-ring-header-{}", std::process::id()));
    let memory = SharedMemory::create(&path, layout::FIRST_SLOT * 8).expect("memory");
    std::fs::remove_file(&path).expect("removed");
    let place = |word: &AtomicU64| (std::ptr::from_ref(word).addr() - memory.words().as_ptr().addr()) / 8;
    let [first, second] = [0, 1].map(|number| ReaderWords::new(&memory, number));
    let first_word = first.lock_byte() / 8;
    let numbers = [
        ("VERSION", layout::VERSION as usize),
        ("HEADER_MAGIC", header::MAGIC),
        ("HEADER_VERSION", header::VERSION),
        ("HEADER_SLOTS", header::SLOTS),
        ("HEADER_SLOT_WORDS", header::SLOT_WORDS),
        ("HEADER_FIRST_SLOT", header::FIRST_SLOT),
        ("HEADER_PUBLISHED", header::PUBLISHED),
        ("HEADER_STATE", header::STATE),
        ("HEADER_WAITS", header::WAITS),
        ("HEADER_TAKEN", header::TAKEN),
        ("HEADER_PROCESS", header::PROCESS),
        ("HEADER_WRITER_LOCK", header::WRITER_LOCK),
        ("OPEN", layout::OPEN as usize),
        ("REPLACED", layout::REPLACED as usize),
        ("ENDED", layout::ENDED as usize),
        ("READERS", layout::READERS),
        ("FIRST_READER", first_word),
        ("READER_WORDS", second.lock_byte() / 8 - first_word),
        ("READER_STATE", place(first.is_active()) - first_word),
        ("READER_CURSOR", place(first.cursor()) - first_word),
        ("READER_LOST", place(first.lost()) - first_word),
        ("FREE", layout::FREE as usize),
        ("ACTIVE", layout::ACTIVE as usize),
        ("EXPECTED", layout::EXPECTED as usize),
        ("SLOT_SEQUENCE", slot::SEQUENCE),
        ("SLOT_INDEX", slot::INDEX),
        ("SLOT_TIME", slot::TIME),
        ("SLOT_PICTURES", slot::PICTURES),
        ("SLOT_RIG", slot::RIG),
        ("SLOT_TABLE", slot::TABLE),
        ("PICTURES", layout::PICTURES),
        ("PICTURE_NAME", picture::NAME),
        ("PICTURE_PIXELS", picture::PIXELS),
        ("PICTURE_WIDTH", picture::WIDTH),
        ("PICTURE_HEIGHT", picture::HEIGHT),
        ("PICTURE_FORMAT", picture::FORMAT),
        ("PICTURE_WORDS", picture::WORDS),
        ("NAME_BYTES", layout::NAME_BYTES),
        ("RGBA8", Format::Rgba8.number() as usize),
        ("RGBA16", Format::Rgba16.number() as usize),
    ];
    let magic = layout::MAGIC.to_ne_bytes();
    let magic = format!("\"{}\"", String::from_utf8_lossy(&magic));
    let numbers = numbers.into_iter().map(|(name, value)| (name.to_owned(), value.to_string()));
    numbers.chain(std::iter::once(("MAGIC".to_owned(), magic))).collect()
}

#[test]
fn the_header_says_what_the_sources_say() {
    assert_eq!(defined(TEXT), expected());
    let wrong = TEXT.replace("HEADER_TAKEN 8", "HEADER_TAKEN 9");
    assert_ne!(defined(&wrong), expected(), "a wrong number is seen");
}
