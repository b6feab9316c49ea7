//! Calibrations of the pixels of an output: nodes with triangles, or a value for each pixel.

mod mesh;
mod raster;

pub use mesh::{MOST_NODES, Mesh, Node};
pub use raster::Raster;

use glam::{DVec2, DVec3};

/// Value of a calibration at one place of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Position in a picture (x, y in 0…1 from the bottom left), point or direction; the rig
    /// determines which.
    pub value: DVec3,
    /// Factor on the displayed (encoded) value, 0…1.
    pub intensity: f64,
}

/// A calibration of one output.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum Grid {
    /// Nodes with triangles. An output of another aspect than the mesh's shows more or less at the
    /// sides.
    Mesh(Mesh),
    /// Nodes with triangles whose positions are −1…1 over the width and over the height of any
    /// output.
    Stretched(Mesh),
    /// A value for each pixel.
    Raster(Raster),
}

impl Grid {
    /// Returns the value at a pixel (from the top left, centres at +½) of an output of `size`
    /// pixels; `None` outside the grid and where it shows nothing.
    pub fn sample(&self, pixel: DVec2, size: (u32, u32)) -> Option<Sample> {
        let (width, height) = (f64::from(size.0), f64::from(size.1));
        match self {
            Self::Mesh(mesh) => mesh.sample(DVec2::new(2.0 * pixel.x - width, height - 2.0 * pixel.y) / height),
            Self::Stretched(mesh) => mesh.sample(DVec2::new(2.0 * pixel.x / width - 1.0, 1.0 - 2.0 * pixel.y / height)),
            Self::Raster(raster) => raster.sample(DVec2::new(pixel.x / width, pixel.y / height)),
        }
    }
}
