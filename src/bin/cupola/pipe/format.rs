//! Formats in which pictures go through a pipe.

use super::{Form, nut, y4m};
use std::io::{Result, Write};

/// Form of pictures in a pipe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// NUT container: RGB without loss, with size and times; ffmpeg takes it without more options.
    Nut,
    /// YUV4MPEG2: 4:4:4, 8 bit, BT.709 of limited range; encoders and GStreamer take it.
    Y4m,
    /// Four bytes for each pixel, red first, and nothing else.
    Raw,
}

/// Length of a unit of time, in seconds: `numerator` ÷ `denominator`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeBase {
    pub numerator: u64,
    pub denominator: u64,
}

impl TimeBase {
    /// Time base of live pictures, as in MPEG.
    pub const LIVE: Self = Self { numerator: 1, denominator: 90_000 };

    /// Converts a time in nanoseconds to these units.
    pub fn units(self, nanoseconds: u64) -> u64 {
        let units = u128::from(nanoseconds) * u128::from(self.denominator);
        u64::try_from(units / (1_000_000_000 * u128::from(self.numerator))).unwrap_or(u64::MAX)
    }
}

/// Writer of pictures of one size.
pub struct Writing {
    form: Form,
    size: (u32, u32),
    has_begun: bool,
    bytes: Vec<u8>,
}

impl Writing {
    pub fn new(form: Form, size: (u32, u32)) -> Self {
        Self { form, size, has_begun: false, bytes: Vec::new() }
    }

    /// Writes a picture, after the beginning of the format if it is the first one.
    pub fn add(&mut self, output: &mut impl Write, rgba: &[u8], time: u64) -> Result<()> {
        let is_first = !std::mem::replace(&mut self.has_begun, true);
        self.bytes.clear();
        match self.form.format {
            Format::Raw => {}
            Format::Nut => {
                if is_first {
                    nut::begin(&mut self.bytes, self.size, self.form.base);
                }
                nut::frame(&mut self.bytes, time, rgba.len());
            }
            Format::Y4m => {
                if is_first {
                    self.bytes.extend(y4m::head(self.size, self.form.rate).into_bytes());
                }
                y4m::frame(&mut self.bytes, rgba);
            }
        }
        output.write_all(&self.bytes)?;
        if self.form.format != Format::Y4m {
            output.write_all(rgba)?;
        }
        output.flush()
    }
}
