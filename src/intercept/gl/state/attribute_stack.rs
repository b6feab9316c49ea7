//! What `glPushAttrib` keeps of the state that is followed.

use crate::backend::gl::KnownState;
use crate::intercept::gl::state::raster_position::RasterPosition;
use crate::intercept::gl::state::window_space::AppState;

/// `GL_MAX_ATTRIB_STACK_DEPTH` of every driver that is known.
pub const ATTRIBUTE_DEPTH: usize = 16;

/// What `glPushAttrib` keeps of what we follow.
pub struct Pushed {
    pub(in crate::intercept::gl) mask: u32,
    pub(in crate::intercept::gl) believed: AppState,
    pub(in crate::intercept::gl) list_base: u32,
    pub(in crate::intercept::gl) known: KnownState,
    /// Where current attributes are kept.
    pub(in crate::intercept::gl) raster: Option<RasterPosition>,
}
