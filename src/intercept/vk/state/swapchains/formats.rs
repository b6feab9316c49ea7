//! Formats of a window's images that can be corrected, and their texels.

use ash::vk;

/// Layout of a texel's colours in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TexelFormat {
    /// Four bytes, red first.
    Rgba8,
    /// Four bytes, blue first.
    Bgra8,
    /// A word of 32 bits with 10 for each colour, red in the lowest.
    Rgb10,
    /// As `Rgb10`, with blue in the lowest bits.
    Bgr10,
    /// Four floats of 16 bits, red first.
    Half,
    /// Four numbers of 16 bits, red first. Only images of Cupola have it.
    Rgba16,
}

impl TexelFormat {
    /// Returns the layout for a format; `None`: windows with this format keep the program's own
    /// picture.
    pub fn of(format: vk::Format) -> Option<Self> {
        match format {
            vk::Format::B8G8R8A8_UNORM | vk::Format::B8G8R8A8_SRGB => Some(Self::Bgra8),
            vk::Format::R8G8B8A8_UNORM | vk::Format::R8G8B8A8_SRGB => Some(Self::Rgba8),
            vk::Format::A8B8G8R8_UNORM_PACK32 | vk::Format::A8B8G8R8_SRGB_PACK32 if cfg!(target_endian = "little") => {
                Some(Self::Rgba8)
            }
            vk::Format::A2B10G10R10_UNORM_PACK32 => Some(Self::Rgb10),
            vk::Format::A2R10G10B10_UNORM_PACK32 => Some(Self::Bgr10),
            vk::Format::R16G16B16A16_SFLOAT => Some(Self::Half),
            _ => None,
        }
    }

    /// Returns the bytes of a texel.
    pub fn size(self) -> usize {
        if matches!(self, Self::Half | Self::Rgba16) { 8 } else { 4 }
    }

    /// Returns red, green and blue of a texel in 16 bits, rounded; `bytes` as for
    /// [`color`](Self::color).
    pub fn deep_color(self, bytes: &[u8]) -> [u16; 3] {
        let byte = |index: usize| bytes.get(index).copied().unwrap_or_default();
        let word = u32::from_ne_bytes([byte(0), byte(1), byte(2), byte(3)]);
        let ten = |shift: u32| (((word >> shift & 1023) * 65535 + 511) / 1023) as u16;
        let number = |index: usize| u16::from_ne_bytes([byte(2 * index), byte(2 * index + 1)]);
        let half = |index: usize| (of_half(number(index)) * 65535.0).round() as u16;
        match self {
            Self::Rgba8 | Self::Bgra8 => self.color(bytes).map(|color| u16::from(color) * 257),
            Self::Rgb10 => [ten(0), ten(10), ten(20)],
            Self::Bgr10 => [ten(20), ten(10), ten(0)],
            Self::Half => [half(0), half(1), half(2)],
            Self::Rgba16 => [number(0), number(1), number(2)],
        }
    }

    /// Returns red, green and blue of a texel in 8 bits, rounded; `bytes` has [`size`](Self::size)
    /// bytes.
    pub fn color(self, bytes: &[u8]) -> [u8; 3] {
        let byte = |index: usize| bytes.get(index).copied().unwrap_or_default();
        let word = u32::from_ne_bytes([byte(0), byte(1), byte(2), byte(3)]);
        let ten = |shift: u32| (((word >> shift & 1023) * 255 + 511) / 1023) as u8;
        let number = |index: usize| u16::from_ne_bytes([byte(2 * index), byte(2 * index + 1)]);
        let half = |index: usize| (of_half(number(index)) * 255.0).round() as u8;
        let eight = |index: usize| ((u32::from(number(index)) + 128) / 257) as u8;
        match self {
            Self::Rgba8 => [byte(0), byte(1), byte(2)],
            Self::Bgra8 => [byte(2), byte(1), byte(0)],
            Self::Rgb10 => [ten(0), ten(10), ten(20)],
            Self::Bgr10 => [ten(20), ten(10), ten(0)],
            Self::Half => [half(0), half(1), half(2)],
            Self::Rgba16 => [eight(0), eight(1), eight(2)],
        }
    }
}

/// Value of a 16-bit float (IEEE 754 binary16). Values outside 0…1 are clamped, and NaN becomes 0.
fn of_half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let value = match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction > 0.0 => 0.0,
        31 => f64::INFINITY,
        _ => (1024.0 + fraction) * 2f64.powi(exponent - 25),
    };
    let signed = if bits >> 15 == 1 { -value } else { value };
    signed.clamp(0.0, 1.0)
}

/// True if the values of a colour space are encoded for a display of the usual kind. The correction
/// computes light for this encoding.
pub fn is_usual(space: vk::ColorSpaceKHR) -> bool {
    use vk::ColorSpaceKHR as C;
    [
        C::SRGB_NONLINEAR,
        C::EXTENDED_SRGB_NONLINEAR_EXT,
        C::DISPLAY_P3_NONLINEAR_EXT,
        C::ADOBERGB_NONLINEAR_EXT,
        C::BT709_NONLINEAR_EXT,
        C::PASS_THROUGH_EXT,
    ]
    .contains(&space)
}

#[cfg(test)]
mod tests {
    use super::TexelFormat;

    #[test]
    fn every_layout_gives_the_same_color() {
        let ten = |red: u32, green: u32, blue: u32| red | green << 10 | blue << 20 | 3 << 30;
        assert_eq!(TexelFormat::Rgba8.color(&[1, 2, 3, 9]), [1, 2, 3]);
        assert_eq!(TexelFormat::Bgra8.color(&[3, 2, 1, 9]), [1, 2, 3]);
        assert_eq!(TexelFormat::Rgb10.color(&ten(1023, 512, 0).to_ne_bytes()), [255, 128, 0]);
        assert_eq!(TexelFormat::Bgr10.color(&ten(0, 512, 1023).to_ne_bytes()), [255, 128, 0]);
        // 1, 0.5, −2.
        let half: Vec<u8> = [0x3c00u16, 0x3800, 0xc000, 0].iter().flat_map(|value| value.to_ne_bytes()).collect();
        assert_eq!(TexelFormat::Half.color(&half), [255, 128, 0]);
        let sixteen: Vec<u8> = [65535u16, 32896, 257, 0].iter().flat_map(|value| value.to_ne_bytes()).collect();
        assert_eq!(TexelFormat::Rgba16.color(&sixteen), [255, 128, 1]);
    }

    #[test]
    fn deep_colors_round_to_the_usual_ones() {
        let ten = 1023_u32 | 300 << 10 | 7 << 20;
        for (format, texel) in [
            (TexelFormat::Rgba8, vec![1, 2, 3, 9]),
            (TexelFormat::Bgra8, vec![200, 128, 255, 9]),
            (TexelFormat::Rgb10, ten.to_ne_bytes().to_vec()),
            (TexelFormat::Bgr10, ten.to_ne_bytes().to_vec()),
            (TexelFormat::Half, [0x3c00u16, 0x3801, 0x0400, 0].iter().flat_map(|value| value.to_ne_bytes()).collect()),
            (TexelFormat::Rgba16, [65535u16, 300, 40_000, 0].iter().flat_map(|value| value.to_ne_bytes()).collect()),
        ] {
            let rounded = format.deep_color(&texel).map(|color| ((u32::from(color) + 128) / 257) as u8);
            assert_eq!(rounded, format.color(&texel), "{format:?}");
        }
        let finer = TexelFormat::Rgb10.deep_color(&ten.to_ne_bytes());
        // Rounded: 65535 · 300 ÷ 1023 and 65535 · 7 ÷ 1023.
        assert_eq!(finer, [65535, 19218, 448], "not multiples of 257");
    }

    #[test]
    fn floats_of_every_kind_are_survived() {
        let byte = |bits: u16| TexelFormat::Half.color(&bits.to_ne_bytes())[0];
        assert_eq!((byte(0x7c00), byte(0xfc00), byte(0x7e00), byte(0x0001)), (255, 0, 0, 0));
        let mut last = 0;
        for bits in 0..=0x7c00 {
            let value = byte(bits);
            assert!(value >= last, "{bits:04x}: more is not darker");
            last = value;
        }
    }
}
