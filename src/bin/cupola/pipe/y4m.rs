//! YUV4MPEG2: a line of text, then a word and three planes for each picture.

use crate::launch::clock::Rate;

/// Luminance of red, green and blue by ITU-R BT.709.
const LUMA: [f64; 3] = [0.2126, 0.7152, 0.0722];
/// Number of fractional bits of the numbers below.
const BITS: u32 = 16;

/// Line at the beginning.
pub fn head((width, height): (u32, u32), rate: Rate) -> String {
    let Rate { frames, seconds } = rate;
    format!("YUV4MPEG2 W{width} H{height} F{frames}:{seconds} Ip A1:1 C444 XCOLORRANGE=LIMITED\n")
}

/// Appends a picture of RGBA.
pub fn frame(bytes: &mut Vec<u8>, rgba: &[u8]) {
    bytes.extend_from_slice(b"FRAME\n");
    let (pixels, _) = rgba.as_chunks::<4>();
    for plane in planes() {
        bytes.extend(pixels.iter().map(|pixel| plane.of(pixel)));
    }
}

/// Value of a plane as a sum of red, green and blue.
struct Plane {
    weights: [i32; 3],
    offset: i32,
}

impl Plane {
    fn new(weights: [f64; 3], offset: i32) -> Self {
        let scale = f64::from(1 << BITS);
        let weights = weights.map(|weight| (weight * scale).round() as i32);
        Self { weights, offset: (offset << BITS) + (1 << (BITS - 1)) }
    }

    fn of(&self, pixel: &[u8; 4]) -> u8 {
        let sum: i32 = self.weights.iter().zip(pixel).map(|(weight, value)| weight * i32::from(*value)).sum();
        ((sum + self.offset) >> BITS) as u8
    }
}

/// Planes with Y from 16 to 235, Cb and Cr from 16 to 240.
fn planes() -> [Plane; 3] {
    let difference = |own: usize| {
        // The difference reaches ±(1 − its own weight).
        let scale = 224.0 / 255.0 / (2.0 * (1.0 - LUMA[own]));
        std::array::from_fn(|color| scale * (f64::from(u8::from(color == own)) - LUMA[color]))
    };
    let luma = LUMA.map(|weight| weight * 219.0 / 255.0);
    [Plane::new(luma, 16), Plane::new(difference(2), 128), Plane::new(difference(0), 128)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with the numbers of BT.709 for 8 bits: black, white, and the full colours.
    #[test]
    fn colours_are_those_of_television() {
        let of = |red: u8, green: u8, blue: u8| {
            let mut bytes = Vec::new();
            frame(&mut bytes, &[red, green, blue, 255]);
            bytes.strip_prefix(b"FRAME\n").map(<[u8]>::to_vec).unwrap_or_default()
        };
        assert_eq!(of(0, 0, 0), [16, 128, 128]);
        assert_eq!(of(255, 255, 255), [235, 128, 128]);
        assert_eq!(of(255, 0, 0), [63, 102, 240]);
        assert_eq!(of(0, 255, 0), [173, 42, 26]);
        assert_eq!(of(0, 0, 255), [32, 240, 118]);
        let line = head((6, 4), Rate { frames: 60_000, seconds: 1001 });
        assert_eq!(line, "YUV4MPEG2 W6 H4 F60000:1001 Ip A1:1 C444 XCOLORRANGE=LIMITED\n");
    }
}
