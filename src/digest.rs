//! Checksums that distinguish contents: XXH3 with 128 bits.

use serde::{Serialize, Serializer};
use std::fmt;
use xxhash_rust::xxh3::Xxh3;

/// Number of bytes that are collected before they are added.
const BLOCK: usize = 4096;

/// Sum of bytes in their order.
///
/// It is not cryptographic: accidental collisions are negligible, deliberate ones are possible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(u128);

impl Digest {
    /// Returns the sum of `bytes`.
    pub fn of(bytes: &[u8]) -> Self {
        Self(xxhash_rust::xxh3::xxh3_128(bytes))
    }

    /// Returns the sum of the bytes that `write` writes.
    pub fn of_written(write: impl FnOnce(&mut dyn std::io::Write) -> Option<()>) -> Option<Self> {
        let mut writer = std::io::BufWriter::with_capacity(BLOCK, Sum(Xxh3::new()));
        write(&mut writer)?;
        Some(Self(writer.into_inner().ok()?.0.digest128()))
    }

    /// Returns the sum as a number.
    pub fn value(&self) -> u128 {
        self.0
    }
}

struct Sum(Xxh3);

impl std::io::Write for Sum {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Sum of all bits of numbers. It replaces large data in messages and in keys.
impl FromIterator<f64> for Digest {
    fn from_iter<T: IntoIterator<Item = f64>>(numbers: T) -> Self {
        let mut sum = Xxh3::new();
        let mut block = Vec::with_capacity(BLOCK);
        for number in numbers {
            block.extend_from_slice(&number.to_le_bytes());
            if block.len() == BLOCK {
                sum.update(&block);
                block.clear();
            }
        }
        sum.update(&block);
        Self(sum.digest128())
    }
}

impl Serialize for Digest {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(to)
    }
}

impl fmt::LowerHex for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::LowerHex::fmt(&self.0, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_tell_order_length_and_every_bit() {
        let numbers = |numbers: &[f64]| numbers.iter().copied().collect::<Digest>();
        assert_ne!(numbers(&[0.0]), numbers(&[-0.0]));
        assert_ne!(numbers(&[1.0, 2.0]), numbers(&[2.0, 1.0]));
        assert_ne!(numbers(&[0.0]), numbers(&[0.0, 0.0]));
        let many: Vec<f64> = (0..2000).map(f64::from).collect();
        let bytes: Vec<u8> = many.iter().flat_map(|number| number.to_le_bytes()).collect();
        assert_eq!(numbers(&many), Digest::of(&bytes));
        for index in [0, 511, 512, 1999] {
            let mut other = many.clone();
            other[index] = f64::from_bits(other[index].to_bits() ^ 1);
            assert_ne!(numbers(&many), numbers(&other), "{index}");
        }
    }

    #[test]
    fn what_is_written_in_pieces_has_the_sum_of_the_whole() {
        let bytes: Vec<u8> = (0..10_000u32).map(|number| number as u8).collect();
        for length in [1, 7, 5000] {
            let write =
                |to: &mut dyn std::io::Write| bytes.chunks(length).try_for_each(|piece| to.write_all(piece)).ok();
            assert_eq!(Digest::of_written(write), Some(Digest::of(&bytes)));
        }
        assert_eq!(Digest::of_written(|_| None), None);
    }
}
