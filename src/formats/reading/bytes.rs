//! Binary files, value by value.

use crate::error::{Error, Result};
use crate::formats::reading::input::invalid;

/// Reader of little-endian values of a binary file, with the offset for messages.
pub(in crate::formats) struct Bytes<'a> {
    name: &'a str,
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    /// Starts at the beginning of the file `name`.
    pub(in crate::formats) fn new(name: &'a str, all: &'a [u8]) -> Self {
        Self { name, all, at: 0 }
    }

    /// Offset of the next value.
    pub(in crate::formats) fn offset(&self) -> usize {
        self.at
    }

    /// Returns the number of bytes that are left.
    pub(in crate::formats) fn left(&self) -> usize {
        self.all.len() - self.at
    }

    /// Error at the next value.
    pub(in crate::formats) fn wrong(&self, why: impl std::fmt::Display) -> Error {
        invalid(self.name, format!("at byte {}: {why}", self.at))
    }

    /// Returns the next `length` bytes, which `what` describes.
    pub(in crate::formats) fn take(&mut self, length: usize, what: &str) -> Result<&'a [u8]> {
        if length > self.left() {
            return Err(
                self.wrong(format!("the file ends; expected {length} bytes of {what}, {} are there", self.left()))
            );
        }
        let taken = &self.all[self.at..self.at + length];
        self.at += length;
        Ok(taken)
    }

    /// Returns the next `COUNT` bytes.
    pub(in crate::formats) fn array<const COUNT: usize>(&mut self, what: &str) -> Result<[u8; COUNT]> {
        let mut array = [0; COUNT];
        array.copy_from_slice(self.take(COUNT, what)?);
        Ok(array)
    }

    /// Reads a 32-bit number.
    pub(in crate::formats) fn u32(&mut self, what: &str) -> Result<u32> {
        Ok(u32::from_le_bytes(self.array(what)?))
    }
}
