//! The NUT container with one stream of RGBA pictures: version 3 of its specification.
//!
//! Every picture has a syncpoint before it, so that a reader may begin at any of them.

use super::TimeBase;

const FILE: &[u8] = b"nut/multimedia container\0";
const MAIN: u64 = start_code(b'M', 0x7A56_1F5F_04AD);
const STREAM: u64 = start_code(b'S', 0x1140_5BF2_F9DB);
const SYNCPOINT: u64 = start_code(b'K', 0xE4AD_EECA_4569);

/// Flags of a frame.
const KEY: u64 = 1;
const HAS_TIME: u64 = 8;
const HAS_SIZE: u64 = 32;
const HAS_CHECKSUM: u64 = 64;
const HAS_FLAGS: u64 = 4096;
/// Bits of a time that may stand alone; a larger number is the whole time plus two to their power.
const TIME_BITS: u32 = 7;

const fn start_code(letter: u8, number: u64) -> u64 {
    ((b'N' as u64) << 56) | ((letter as u64) << 48) | number
}

/// A number in groups of seven bits, the highest first.
fn number(bytes: &mut Vec<u8>, value: u64) {
    let groups = (64 - value.leading_zeros()).div_ceil(7).max(1);
    for group in (0..groups).rev() {
        let more = if group > 0 { 0x80 } else { 0 };
        bytes.push((value >> (7 * group)) as u8 & 0x7F | more);
    }
}

/// Sum of the polynomial 0x04C11DB7, highest bit first, without complements.
fn checksum(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0, |sum: u32, byte| {
        (0..8).fold(
            sum ^ u32::from(*byte) << 24,
            |sum, _| {
                if sum >> 31 == 1 { sum << 1 ^ 0x04C1_1DB7 } else { sum << 1 }
            },
        )
    })
}

fn packet(bytes: &mut Vec<u8>, code: u64, content: &[u8]) {
    bytes.extend(code.to_be_bytes());
    number(bytes, content.len() as u64 + 4);
    bytes.extend(content);
    bytes.extend(checksum(content).to_be_bytes());
}

/// Adds what stands before the first picture.
pub fn begin(bytes: &mut Vec<u8>, (width, height): (u32, u32), base: TimeBase) {
    bytes.extend(FILE);
    let mut main = Vec::new();
    // Version, streams, the farthest syncpoint, one time base.
    [3, 1, 32_767, 1, base.numerator, base.denominator].iter().for_each(|value| number(&mut main, *value));
    // One kind of frame, whose flags stand in the frame: 6 numbers, of which the last is how many
    // codes are of this kind; the code N is of none.
    [HAS_FLAGS, 6, 0, 1, 0, 0, 0, 255].iter().for_each(|value| number(&mut main, *value));
    // No shortened heads of frames.
    number(&mut main, 0);
    packet(bytes, MAIN, &main);
    let mut stream = Vec::new();
    // Number, class video, code of the codec.
    [0, 0, 4].iter().for_each(|value| number(&mut stream, *value));
    stream.extend(b"RGBA");
    // Time base, bits, the largest step of time, delay, flags, no data of the codec.
    [0, TIME_BITS.into(), 1 << 32, 0, 0, 0].iter().for_each(|value| number(&mut stream, *value));
    // Square pixels, no word on colours.
    [width.into(), height.into(), 1, 1, 0].iter().for_each(|value| number(&mut stream, *value));
    packet(bytes, STREAM, &stream);
}

/// Adds what stands before the `size` bytes of a picture.
pub fn frame(bytes: &mut Vec<u8>, time: u64, size: usize) {
    let mut sync = Vec::new();
    // The picture that follows is the one to begin with.
    [time, 0].iter().for_each(|value| number(&mut sync, *value));
    packet(bytes, SYNCPOINT, &sync);
    let mut head = vec![0];
    [KEY | HAS_TIME | HAS_SIZE | HAS_CHECKSUM, time.saturating_add(1 << TIME_BITS), size as u64]
        .iter()
        .for_each(|value| number(&mut head, *value));
    let sum = checksum(&head);
    bytes.extend(head);
    bytes.extend(sum.to_be_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_groups_of_seven_bits() {
        for (value, expected) in
            [(0, vec![0]), (127, vec![127]), (128, vec![0x81, 0]), (32_767, vec![0x81, 0xFF, 0x7F])]
        {
            let mut bytes = Vec::new();
            number(&mut bytes, value);
            assert_eq!(bytes, expected, "{value}");
        }
        let mut most = Vec::new();
        number(&mut most, u64::MAX);
        assert_eq!((most.len(), most[0]), (10, 0x81));
    }

    /// The sum of a packet with its own sum is 0, as readers check it.
    #[test]
    fn a_sum_over_itself_is_zero() {
        let mut bytes = b"123456789".to_vec();
        bytes.extend(checksum(&bytes).to_be_bytes());
        assert_eq!(checksum(&bytes), 0);
        bytes[3] ^= 1;
        assert_ne!(checksum(&bytes), 0);
    }
}
