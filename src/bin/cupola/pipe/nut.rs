//! The NUT container with one stream of RGBA pictures: version 3 of its specification.
//!
//! Every picture has a syncpoint before it, so that a reader may begin at any picture.

use super::TimeBase;
use cupola::ring::Picture;
use std::io::{Error, ErrorKind, Read, Result};

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
/// Flags of each frame that is written here.
const FLAGS: u64 = KEY | HAS_TIME | HAS_SIZE | HAS_CHECKSUM;
/// Number of bits of a short time. A larger number is the whole time plus two to the power of this.
const TIME_BITS: u32 = 7;

const fn start_code(letter: u8, number: u64) -> u64 {
    ((b'N' as u64) << 56) | ((letter as u64) << 48) | number
}

/// Appends a number in groups of seven bits, the highest first.
fn number(bytes: &mut Vec<u8>, value: u64) {
    let groups = (64 - value.leading_zeros()).div_ceil(7).max(1);
    for group in (0..groups).rev() {
        let more = if group > 0 { 0x80 } else { 0 };
        bytes.push((value >> (7 * group)) as u8 & 0x7F | more);
    }
}

/// Checksum with the polynomial 0x04C11DB7, highest bit first, without complements.
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

/// Appends the part before the first picture.
pub fn begin(bytes: &mut Vec<u8>, (width, height): (u32, u32), base: TimeBase) {
    bytes.extend(FILE);
    let mut main = Vec::new();
    // Version, number of streams, farthest distance of syncpoints, one time base.
    [3, 1, 32_767, 1, base.numerator, base.denominator].iter().for_each(|value| number(&mut main, *value));
    // One kind of frame, whose flags are in the frame: 6 numbers, of which the last is the number
    // of codes of this kind; the code N has no kind.
    [HAS_FLAGS, 6, 0, 1, 0, 0, 0, 255].iter().for_each(|value| number(&mut main, *value));
    // There are no shortened frame headers.
    number(&mut main, 0);
    packet(bytes, MAIN, &main);
    let mut stream = Vec::new();
    // Number, class (video), length of the codec's code.
    [0, 0, 4].iter().for_each(|value| number(&mut stream, *value));
    stream.extend(b"RGBA");
    // Time base, bits, largest step of time, delay, flags, no codec data.
    [0, TIME_BITS.into(), 1 << 32, 0, 0, 0].iter().for_each(|value| number(&mut stream, *value));
    // Pixels are square; the colours are not defined.
    [width.into(), height.into(), 1, 1, 0].iter().for_each(|value| number(&mut stream, *value));
    packet(bytes, STREAM, &stream);
}

/// Appends the part before the `size` bytes of a picture.
pub fn frame(bytes: &mut Vec<u8>, time: u64, size: usize) {
    let mut sync = Vec::new();
    // Decoding can begin with the next picture.
    [time, 0].iter().for_each(|value| number(&mut sync, *value));
    packet(bytes, SYNCPOINT, &sync);
    let mut head = vec![0];
    [FLAGS, time.saturating_add(1 << TIME_BITS), size as u64].iter().for_each(|value| number(&mut head, *value));
    let sum = checksum(&head);
    bytes.extend(head);
    bytes.extend(sum.to_be_bytes());
}

/// Longest packet that is read, and greatest width and height of pictures.
const LONGEST_PACKET: u64 = 4096;
const LARGEST: u64 = 16384;

/// Reader of the pictures that this file writes; it reads no other kind of NUT.
pub struct Reading<R> {
    input: R,
    size: Option<(u32, u32)>,
}

fn other() -> Error {
    Error::new(ErrorKind::InvalidData, "these are no pictures as cupola stream - sends them (NUT with RGBA)")
}

impl<R: Read> Reading<R> {
    pub fn new(input: R) -> Self {
        Self { input, size: None }
    }

    fn byte(&mut self) -> Result<u8> {
        let mut byte = [0];
        self.input.read_exact(&mut byte)?;
        Ok(byte[0])
    }

    fn number(&mut self, read: &mut Vec<u8>) -> Result<u64> {
        let mut value: u64 = 0;
        loop {
            let byte = self.byte()?;
            read.push(byte);
            value = value.checked_mul(128).ok_or_else(other)? + u64::from(byte & 0x7F);
            if byte < 0x80 {
                return Ok(value);
            }
        }
    }

    /// Reads the next picture. Returns false if there are no more.
    pub fn next(&mut self, picture: &mut Picture) -> Result<bool> {
        loop {
            let first = match self.byte() {
                Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(false),
                first => first?,
            };
            match first {
                b'N' => self.packet()?,
                0 => return self.picture(picture).map(|()| true),
                _ if first == FILE[0] => {
                    let mut rest = [0; FILE.len() - 1];
                    self.input.read_exact(&mut rest)?;
                    (rest == FILE[1..]).then_some(()).ok_or_else(other)?;
                }
                _ => return Err(other()),
            }
        }
    }

    fn packet(&mut self) -> Result<()> {
        let mut code = [b'N'; 8];
        self.input.read_exact(&mut code[1..])?;
        let length = self.number(&mut Vec::new())?;
        if length > LONGEST_PACKET {
            return Err(other());
        }
        let mut content = vec![0; length as usize];
        self.input.read_exact(&mut content)?;
        // The checksum of a packet with its own checksum at the end is 0.
        if checksum(&content) != 0 {
            return Err(other());
        }
        if u64::from_be_bytes(code) == STREAM {
            let mut stream = Reading::new(&content[..]);
            let mut number = || stream.number(&mut Vec::new());
            // Number, class, code of the codec with its four letters, then six numbers.
            let numbers = (0..13).map(|_| number()).collect::<Result<Vec<u64>>>()?;
            if numbers[2..7] != [4, b'R'.into(), b'G'.into(), b'B'.into(), b'A'.into()] {
                return Err(other());
            }
            let (width, height) = (number()?, number()?);
            if ![width, height].iter().all(|side| (1..=LARGEST).contains(side)) {
                return Err(other());
            }
            self.size = Some((width as u32, height as u32));
        }
        Ok(())
    }

    fn picture(&mut self, picture: &mut Picture) -> Result<()> {
        let (width, height) = self.size.ok_or_else(other)?;
        let mut head = vec![0];
        let flags = self.number(&mut head)?;
        let _time = self.number(&mut head)?;
        let length = self.number(&mut head)?;
        let mut sum = [0; 4];
        self.input.read_exact(&mut sum)?;
        let expected = u64::from(width) * u64::from(height) * 4;
        if flags != FLAGS || length != expected || checksum(&head) != u32::from_be_bytes(sum) {
            return Err(other());
        }
        picture.size = (width, height);
        picture.rgba.resize(expected as usize, 0);
        self.input.read_exact(&mut picture.rgba)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_out_as_they_went_in() {
        let base = TimeBase { numerator: 1, denominator: 90_000 };
        let mut bytes = Vec::new();
        let mut write = |size: (u32, u32), values: &[u8]| {
            begin(&mut bytes, size, base);
            for (time, value) in (0..).zip(values) {
                let rgba = vec![*value; (size.0 * size.1 * 4) as usize];
                frame(&mut bytes, 3000 * time, rgba.len());
                bytes.extend(rgba);
            }
        };
        // The window changes its size.
        write((3, 2), &[5, b'N', b'n', 0]);
        write((200, 1), &[7]);
        let read = |bytes: &[u8]| -> Result<Vec<((u32, u32), u8)>> {
            let (mut reading, mut picture, mut all) = (Reading::new(bytes), Picture::default(), Vec::new());
            while reading.next(&mut picture)? {
                assert!(picture.rgba.iter().all(|value| *value == picture.rgba[0]));
                all.push((picture.size, picture.rgba[0]));
            }
            Ok(all)
        };
        let expected = [((3, 2), 5), ((3, 2), b'N'), ((3, 2), b'n'), ((3, 2), 0), ((200, 1), 7)];
        assert_eq!(read(&bytes).expect("pictures"), expected);
        for place in [3, 40, 60, 90] {
            let mut wrong = bytes.clone();
            wrong[place] ^= 4;
            assert!(read(&wrong).is_err(), "{place}");
        }
        assert!(read(b"YUV4MPEG2").is_err() && read(&bytes[..bytes.len() - 1]).is_err());
    }

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

    /// The checksum of a packet with its own checksum is 0; readers check it this way.
    #[test]
    fn a_sum_over_itself_is_zero() {
        let mut bytes = b"123456789".to_vec();
        bytes.extend(checksum(&bytes).to_be_bytes());
        assert_eq!(checksum(&bytes), 0);
        bytes[3] ^= 1;
        assert_ne!(checksum(&bytes), 0);
    }
}
