//! State of the compatibility profile.
//!
//! [`projection`] holds matrices, [`raster_position`] the raster position. [`begin_end`] is the
//! Begin/End that the program is in, recorded by [`vertex_recorder`] as [`vertex_commands`].

pub mod begin_end;
pub mod projection;
pub mod raster_position;
pub mod vertex_commands;
pub mod vertex_recorder;

use crate::backend::gl::driver::api::Gl;
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
    /// True between `glBegin` and `glEnd` of a draw of Cupola.
    pub fn under_way(&self) -> bool {
        self.immediate.under_way()
    }

    /// True if the driver is to refuse a command that is not allowed between Begin and End.
    pub fn refuses(&mut self, gl: &Gl) -> bool {
        self.immediate.refuses(gl)
    }

    /// Returns the origin of the window in the coordinates of the driver's raster position.
    pub fn raster_origin(&self) -> [i32; 2] {
        self.raster.origin()
    }

    /// Returns the part of the raster position that `glPushAttrib` saves.
    pub fn saved_raster(&self) -> RasterPosition {
        self.raster.saved()
    }

    /// `glPopAttrib` restores the raster position.
    pub fn restore_raster(&mut self, raster: RasterPosition) {
        self.raster = raster;
    }
}
