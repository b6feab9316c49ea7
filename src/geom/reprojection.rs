//! Clip-space re-projection: from the program's own clip coordinates to a view's.

use super::Frustum;
use glam::{DMat3, DVec3};

/// The part of a program's perspective matrix that re-projection needs:
/// `P = [A 0 B 0; 0 C D 0; 0 0 E F; 0 0 −1 0]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Horizontal scale, 1/tan of half the horizontal field of view.
    pub a: f64,
    /// Horizontal off-centre term.
    pub b: f64,
    /// Vertical scale.
    pub c: f64,
    /// Vertical off-centre term.
    pub d: f64,
    /// Depth scale.
    pub e: f64,
    /// Depth offset, where known; from a model-view-projection matrix it often is not.
    pub f: Option<f64>,
}

/// How a program's camera is adapted to the dome (`[camera]` of a rig).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraAdjustment {
    /// Factor on the tangents of every direction; > 1 enlarges what the program shows.
    pub zoom: f64,
    /// How far the eye is moved, in the program's own units, along its camera axes.
    pub shift: DVec3,
    /// Camera axes of the program → axes of the viewer (orthonormal).
    pub rotation: DMat3,
}

/// What a 4×4 matrix of a program is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MatrixClass {
    /// A perspective projection, alone or times a similarity.
    Perspective(Intrinsics),
    /// Keeps w constant: a model, view or orthographic matrix.
    Affine,
    /// Neither (singular, not finite, or a perspective with non-uniform scale or skew in it).
    Other,
}

/// The rows that take a program's clip coordinates to a view's, in ratio form
/// (`x' = rx·(cx, cy, cw) + rx[3]·q` and so on for y and w, `q = cz + E·cw`, `z' = q − E·w'`;
/// `z' = w'` where `cz = cw`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipRows {
    /// Row for x'.
    pub x: [f64; 4],
    /// Row for y'.
    pub y: [f64; 4],
    /// Row for w'.
    pub w: [f64; 4],
    /// E of the program's matrix.
    pub e: f64,
}

/// What `matrix` (column-major, as OpenGL takes it) is.
pub fn classify(matrix: &[f64; 16]) -> MatrixClass {
    let _ = matrix;
    MatrixClass::Other
}

/// The rows for a view with axes `rotation` (viewer → view) and opening `frustum`.
pub fn clip_rows(p: &Intrinsics, camera: &CameraAdjustment, rotation: DMat3, frustum: &Frustum) -> ClipRows {
    let _ = (p, camera, rotation, frustum);
    ClipRows { x: [0.0; 4], y: [0.0; 4], w: [0.0; 4], e: 0.0 }
}

impl ClipRows {
    /// The same as one 4×4 matrix (column-major) to be multiplied from the left to the program's projection.
    pub fn matrix(&self) -> [f64; 16] {
        [0.0; 16]
    }
}
