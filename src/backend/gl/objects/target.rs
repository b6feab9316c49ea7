//! The place where an output is shown.

use crate::correct::LowerLeftRect;

/// Place at which an output is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target {
    /// The framebuffer object; 0 is the window. Its first draw buffer is written.
    pub framebuffer: u32,
    /// Its place there. Another size than the output's own scales it, without filtering anew: the
    /// map is evaluated where the pixels are.
    pub viewport: LowerLeftRect,
}
