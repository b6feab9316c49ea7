//! Targets of the correction.

use crate::correct::LowerLeftRect;

/// Place where an output is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Target {
    /// The framebuffer object; 0 is the window. Its first draw buffer is written.
    pub framebuffer: u32,
    /// Rectangle of the output there. With another size than the output's own, the picture is
    /// scaled without a second filter: the map is evaluated at each pixel of the target.
    pub viewport: LowerLeftRect,
}
