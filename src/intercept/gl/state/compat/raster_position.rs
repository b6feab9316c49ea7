//! The raster position.

/// Raster position of the program: in the scene, or in a tile.
#[derive(Clone, Default)]
pub struct RasterPosition {
    pub(in crate::intercept::gl) scene: Option<ScenePosition>,
    /// The origin of the tile in whose pixels the driver has it; the program has it in its
    /// window's.
    pub(in crate::intercept::gl) origin: [i32; 2],
    /// Each view's projection when the position was set.
    pub(in crate::intercept::gl) projections: Vec<[f64; 16]>,
}

impl RasterPosition {
    /// The origin of the window in the driver's raster position.
    pub fn origin(&self) -> [i32; 2] {
        self.origin
    }

    /// A new position is set; the origin of the old one. The place for projections is used again.
    pub(in crate::intercept::gl) fn forget(&mut self) -> [i32; 2] {
        self.scene = None;
        std::mem::take(&mut self.origin)
    }

    /// Returns the part that is put back with this position.
    pub fn saved(&self) -> Self {
        if self.scene.is_some() { self.clone() } else { Self { origin: self.origin, ..Self::default() } }
    }
}

/// A raster position in the scene.
#[derive(Clone)]
pub(in crate::intercept::gl) struct ScenePosition {
    pub(in crate::intercept::gl) object: [f64; 4],
    pub(in crate::intercept::gl) model_view: [f64; 16],
    /// Colour that the position took with it, lit if light is on. `texture` is its texture
    /// coordinate.
    pub(in crate::intercept::gl) color: [f32; 4],
    pub(in crate::intercept::gl) texture: [f32; 4],
    /// The range of depths in which it was set.
    pub(in crate::intercept::gl) depths: [f64; 2],
    /// Distance by which bitmaps have moved it since, in pixels.
    pub(in crate::intercept::gl) moved: [f32; 2],
}
