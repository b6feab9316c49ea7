//! State of the compatibility profile.
//!
//! [`projection`] holds matrices, [`raster_position`] the raster position. [`begin_end`] is the
//! Begin/End that the program is in, recorded by [`vertex_recorder`] as [`vertex_commands`].

pub mod begin_end;
pub mod projection;
pub mod raster_position;
pub mod vertex_commands;
pub mod vertex_recorder;

use crate::intercept::gl::state::compat::begin_end::Immediate;
use crate::intercept::gl::state::compat::projection::Projection;
use crate::intercept::gl::state::compat::raster_position::RasterPosition;

/// State of the compatibility profile, without display lists.
#[derive(Default)]
pub struct Compat {
    /// The fixed-function projection.
    pub(in crate::intercept::gl) projection: Projection,
    /// The Begin/End that the program is in.
    pub(in crate::intercept::gl) immediate: Immediate,
    /// The raster position.
    pub(in crate::intercept::gl) raster: RasterPosition,
}

impl Compat {
    /// `glPopAttrib` restores the raster position.
    pub fn restore_raster(&mut self, raster: RasterPosition) {
        self.raster = raster;
    }
}
