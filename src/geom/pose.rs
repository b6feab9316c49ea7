//! Where something stands and how it is turned.

use glam::{DMat3, DVec3};

/// A position and an orientation in a parent frame (right-handed, x right, y up, −z forward).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Where the origin of the posed frame is, in the parent frame.
    pub position: DVec3,
    /// Local axes → parent axes; orthonormal. Its columns are the local x, y and z axes.
    pub rotation: DMat3,
}

/// The rotation (local → parent) of something turned by `yaw` (right-positive), then `pitch`
/// (up-positive), then `roll` (clockwise-positive as seen by the viewer), all in radians.
pub fn rotation(yaw: f64, pitch: f64, roll: f64) -> DMat3 {
    DMat3::from_rotation_y(-yaw) * DMat3::from_rotation_x(pitch) * DMat3::from_rotation_z(-roll)
}

impl Pose {
    /// A pose from a position and the angles of [`rotation`], in radians.
    pub fn new(position: DVec3, yaw: f64, pitch: f64, roll: f64) -> Self {
        Self { position, rotation: rotation(yaw, pitch, roll) }
    }
}
