//! Sums that tell contents apart: what was drawn in two frames, what results on disk were computed from.

use std::fmt;

/// Two sums of 64 bits of numbers in their order.
///
/// Contents that differ by accident have equal sums once in 2¹²⁸ times; who wants equal sums can find some.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest([u64; 2]);

impl Default for Digest {
    fn default() -> Self {
        Self([0x9E37_79B9_7F4A_7C15, 0xC2B2_AE3D_27D4_EB4F])
    }
}

impl Digest {
    /// Adds a number.
    #[inline]
    pub fn add(&mut self, word: u64) {
        let product = u128::from(self.0[0] ^ word).wrapping_mul(0xA076_1D64_78BD_642F_E703_7ED1_A0B4_28DB);
        self.0[0] = (product as u64) ^ (product >> 64) as u64;
        self.0[1] = (self.0[1].rotate_left(23) ^ word).wrapping_mul(0x9FB2_1C65_1E98_DF25);
    }

    /// Adds bytes and how many they are.
    pub fn add_bytes(&mut self, bytes: &[u8]) {
        self.add(bytes.len() as u64);
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|word| self.add(u64::from_le_bytes(*word)));
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        self.add(u64::from_le_bytes(last));
    }

    /// Both sums.
    pub fn value(&self) -> u128 {
        (u128::from(self.0[0]) << 64) | u128::from(self.0[1])
    }
}

/// Text is added as it comes: the same text in other pieces has other sums.
impl fmt::Write for Digest {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.add_bytes(text.as_bytes());
        Ok(())
    }
}

/// Of many numbers; in place of them where values are written for people.
impl FromIterator<f64> for Digest {
    fn from_iter<T: IntoIterator<Item = f64>>(numbers: T) -> Self {
        let mut digest = Self::default();
        numbers.into_iter().for_each(|number| digest.add(number.to_bits()));
        digest
    }
}

impl fmt::LowerHex for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::LowerHex::fmt(&self.value(), f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_tell_order_length_and_every_bit() {
        let sum = |words: &[u64]| {
            let mut digest = Digest::default();
            words.iter().for_each(|word| digest.add(*word));
            digest
        };
        assert_eq!(sum(&[1, 2, 3]), sum(&[1, 2, 3]));
        let mut seen = vec![sum(&[]), sum(&[0]), sum(&[0, 0]), sum(&[1, 2]), sum(&[2, 1])];
        for bit in 0..64 {
            seen.push(sum(&[5, 1 << bit, 7]));
            seen.push(sum(&[1 << bit]));
        }
        // Words that undo what the first multiplication has, so that a product is nothing.
        seen.push(sum(&[Digest::default().0[0], 1]));
        seen.push(sum(&[Digest::default().0[0], 2]));
        for (i, one) in seen.iter().enumerate() {
            assert!(seen[..i].iter().all(|other| one != other), "{i}");
        }
        let bytes = |bytes: &[u8]| {
            let mut digest = Digest::default();
            digest.add_bytes(bytes);
            digest
        };
        assert_ne!(bytes(&[1, 2, 3]), bytes(&[1, 2, 3, 0]));
        assert_ne!(bytes(&[0; 8]), bytes(&[0; 9]));
        assert_eq!(bytes(&[9; 20]), bytes(&[9; 20]));
        let numbers = |numbers: &[f64]| numbers.iter().copied().collect::<Digest>();
        assert_ne!(numbers(&[0.0]), numbers(&[-0.0]));
        assert_ne!(numbers(&[1.0, 2.0]), numbers(&[2.0, 1.0]));
    }
}
