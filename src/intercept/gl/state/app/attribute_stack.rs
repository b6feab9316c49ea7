//! State that `glPushAttrib` saves, as far as Cupola follows it.

use crate::backend::gl::KnownState;
use crate::intercept::gl::state::app::window_arrays::WindowArrays;
use crate::intercept::gl::state::app::window_buffers::DrawBuffers;
use crate::intercept::gl::state::compat::raster_position::RasterPosition;

/// `GL_MAX_ATTRIB_STACK_DEPTH` of all known drivers.
pub const ATTRIBUTE_DEPTH: usize = 16;

/// State that `glPushAttrib` saves, as far as Cupola follows it.
pub struct Pushed {
    pub(in crate::intercept::gl) mask: u32,
    pub(in crate::intercept::gl) saved: SavedAppState,
    pub(in crate::intercept::gl) list_base: u32,
    pub(in crate::intercept::gl) known: KnownState,
    /// Raster position, if current attributes are saved.
    pub(in crate::intercept::gl) raster: Option<RasterPosition>,
}

/// Part of the app state that `glPushAttrib` saves.
#[derive(Clone, Debug)]
pub struct SavedAppState {
    pub(in crate::intercept::gl) arrays: WindowArrays,
    /// Draw buffers of the window, if it was bound.
    pub(in crate::intercept::gl) draw_buffers: Option<DrawBuffers>,
    /// Read buffer of the window, if it was bound.
    pub(in crate::intercept::gl) read_buffer: Option<u32>,
    pub(in crate::intercept::gl) matrix_mode: u32,
}
