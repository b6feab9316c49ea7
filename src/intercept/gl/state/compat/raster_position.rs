//! The raster position.

/// Raster position of the program: in the scene, or in a tile.
#[derive(Clone, Default)]
pub struct RasterPosition {
    pub(in crate::intercept::gl) scene: Option<ScenePosition>,
    /// Origin of the tile to which the driver's raster position is relative. The program's raster
    /// position is relative to its window.
    pub(in crate::intercept::gl) origin: [i32; 2],
    /// Each view's projection when the position was set.
    pub(in crate::intercept::gl) projections: Vec<[f64; 16]>,
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

/// A raster position in the scene.
#[derive(Clone)]
pub(in crate::intercept::gl) struct ScenePosition {
    pub(in crate::intercept::gl) object: [f64; 4],
    pub(in crate::intercept::gl) model_view: [f64; 16],
    /// Current colour at the time when the position was set, lit if lighting was on. `texture` is
    /// the texture coordinate at that time.
    pub(in crate::intercept::gl) color: [f32; 4],
    pub(in crate::intercept::gl) texture: [f32; 4],
    /// Depth range at the time when the position was set.
    pub(in crate::intercept::gl) depths: [f64; 2],
    /// Distance by which bitmaps have moved the position since then, in pixels.
    pub(in crate::intercept::gl) moved: [f32; 2],
}
