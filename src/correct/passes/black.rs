//! Black level of each pixel, as the shaders get it.

use crate::blend::code_of;
use crate::rig::{Black, BlackValues, Blend, Flip};

/// Displayed values of black over an output, in any size; row 0 at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct BlackPicture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green, blue and 1, 16 bits each.
    pub codes: Vec<[u16; 4]>,
}

impl BlackPicture {
    /// Returns the picture for an output with this display, mirrored as the output is.
    pub(in crate::correct) fn of(black: &Black, display: &Blend, flip: Flip) -> Self {
        let code = |level: f32, channel: usize| {
            let level = f64::from(level);
            let code = match black.values {
                BlackValues::Displayed => level,
                BlackValues::Light => code_of(level, display, channel),
            };
            (code.clamp(0.0, 1.0) * f64::from(u16::MAX)).round() as u16
        };
        let pixel = |value: &[f32; 3]| [code(value[0], 0), code(value[1], 1), code(value[2], 2), u16::MAX];
        let codes: Vec<_> = black.levels.values.iter().map(pixel).collect();
        let (width, height) = black.levels.size;
        Self { width, height, codes: flip.items(&codes, width as usize) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::Levels;

    #[test]
    fn light_becomes_what_is_displayed() {
        let levels = Levels { size: (2, 1), values: vec![[0.0, 0.25, 1.0], [0.0225, 0.02, 0.04]] };
        let black = |values| Black { file: "black.pfm".into(), levels: levels.clone(), values };
        let display = Blend { gamma: 2.0, ..Blend::default() };
        let mirrored = Flip { horizontal: true, vertical: false };
        let codes = |values, flip| BlackPicture::of(&black(values), &display, flip).codes;
        assert_eq!(codes(BlackValues::Displayed, Flip::default())[0], [0, 16384, 65535, 65535]);
        assert_eq!(codes(BlackValues::Light, mirrored)[1], [0, 32768, 65535, 65535]);
        assert_eq!(codes(BlackValues::Light, mirrored)[0], [9830, 9268, 13107, 65535]);
    }
}
