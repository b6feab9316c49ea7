//! The raster position.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::values::integer;
use glam::{DMat4, DVec4, Vec2};

/// Raster position of the program: in the scene, or in a tile.
#[derive(Clone, Default)]
pub struct RasterPosition {
    pub(in crate::intercept::gl) scene: Option<ScenePosition>,
    /// Origin of the tile to which the driver's raster position is relative. The program's raster
    /// position is relative to its window.
    pub(in crate::intercept::gl) origin: [i32; 2],
    /// Each view's projection when the position was set.
    pub(in crate::intercept::gl) projections: Vec<DMat4>,
}

impl RasterPosition {
    /// Returns the origin of the window in the coordinates of the driver's raster position.
    pub fn origin(&self) -> [i32; 2] {
        self.origin
    }

    /// Forgets the position, as a new one is set. Returns the origin of the old one. The memory of
    /// the projections is used again.
    pub(in crate::intercept::gl) fn forget(&mut self) -> [i32; 2] {
        self.scene = None;
        std::mem::take(&mut self.origin)
    }

    /// Returns the part that is needed to restore this position.
    pub fn saved(&self) -> Self {
        if self.scene.is_some() { self.clone() } else { Self { origin: self.origin, ..Self::default() } }
    }
}

/// Greatest number of units whose texture coordinates are followed: that of all known drivers.
const UNITS: usize = 8;

/// Current texture coordinates of all units of the fixed-function pipeline.
#[derive(Clone)]
pub(in crate::intercept::gl) struct TextureCoordinates {
    coordinates: [[f32; 4]; UNITS],
    /// Number of units of the driver.
    units: usize,
}

impl TextureCoordinates {
    /// Returns the present coordinates.
    ///
    /// # Safety
    /// A context with the fixed-function pipeline must be current.
    pub(in crate::intercept::gl) unsafe fn of(gl: &Gl) -> Self {
        let units = integer(gl, api::GL_MAX_TEXTURE_COORDS).clamp(1, UNITS as i32) as usize;
        let active = integer(gl, api::GL_ACTIVE_TEXTURE) as u32;
        let mut coordinates = [[0.0; 4]; UNITS];
        for (unit, coordinates) in (0..).zip(&mut coordinates[..units]) {
            // SAFETY: writes four floats; a unit of the driver.
            unsafe {
                gl.active_texture(api::GL_TEXTURE0 + unit);
                gl.get_floatv(api::GL_CURRENT_TEXTURE_COORDS, coordinates.as_mut_ptr());
            }
        }
        // SAFETY: puts back what was active.
        unsafe { gl.active_texture(active) };
        Self { coordinates, units }
    }

    /// Sets these coordinates.
    ///
    /// # Safety
    /// As for [`Self::of`].
    pub(in crate::intercept::gl) unsafe fn set(&self, gl: &Gl) {
        for (unit, coordinates) in (0..).zip(&self.coordinates[..self.units]) {
            // SAFETY: four floats; a unit of the driver.
            unsafe { gl.multi_tex_coord4fv(api::GL_TEXTURE0 + unit, coordinates.as_ptr()) };
        }
    }
}

/// A raster position in the scene.
#[derive(Clone)]
pub(in crate::intercept::gl) struct ScenePosition {
    pub(in crate::intercept::gl) object: DVec4,
    pub(in crate::intercept::gl) model_view: DMat4,
    /// Current colour at the time when the position was set, lit if lighting was on.
    pub(in crate::intercept::gl) color: [f32; 4],
    /// Texture coordinates of all units at that time.
    pub(in crate::intercept::gl) texture: TextureCoordinates,
    /// Depth range at the time when the position was set.
    pub(in crate::intercept::gl) depths: [f64; 2],
    /// Distance by which bitmaps have moved the position since then, in pixels.
    pub(in crate::intercept::gl) moved: Vec2,
}
