//! Properties of an output's picture.

use crate::correct::passes::mask::Mask;
use crate::correct::passes::source::Source;
use crate::geom::ContentMap;
use crate::rig::Flip;

/// Properties of an output's picture that the rig does not say.
pub(in crate::correct) struct Picture {
    /// Its map.
    pub source: Source,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Its weight image.
    pub mask: Option<Mask>,
    /// Mirroring of the finished picture.
    pub flip: Flip,
    /// Place of a direction in the program's window, if that is shown as it is.
    pub content: Option<ContentMap>,
}
