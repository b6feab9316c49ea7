//! Properties of an output's picture.

use crate::correct::passes::mask::Mask;
use crate::correct::passes::source::Source;
use crate::geom::ContentMap;
use crate::rig::Flip;

/// Properties of an output's picture, computed from the rig.
pub(in crate::correct) struct Picture {
    /// Map of the picture.
    pub source: Source,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Weight image.
    pub mask: Option<Mask>,
    /// Mirroring of the finished picture.
    pub flip: Flip,
    /// Maps a direction to a place in the program's window, if the window is content.
    pub content: Option<ContentMap>,
}
