//! Position and orientation of an object.

use glam::{DMat3, DVec3};

/// A position and an orientation in a parent frame (right-handed, x right, y up, −z forward).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Pose {
    /// Position of the origin of the posed frame, in the parent frame.
    pub position: DVec3,
    /// Local axes → parent axes; orthonormal. Its columns are the local x, y and z axes.
    pub rotation: DMat3,
}

/// Returns the rotation (local → parent) of an object that is turned by `yaw` (right-positive),
/// then `pitch` (up-positive), then `roll` (clockwise-positive as seen by the viewer), all in
/// radians.
pub fn rotation(yaw: f64, pitch: f64, roll: f64) -> DMat3 {
    DMat3::from_rotation_y(-yaw) * DMat3::from_rotation_x(pitch) * DMat3::from_rotation_z(-roll)
}

/// Returns yaw, pitch and roll (radians) of a rotation: the inverse of [`rotation`]. Yaw and roll
/// are in −π…π, pitch in −π/2…π/2. Straight up and straight down, yaw and roll turn about the same
/// axis; then yaw is 0.
pub fn angles(rotation: &DMat3) -> [f64; 3] {
    let forward = -rotation.z_axis;
    let level = forward.x.hypot(forward.z);
    let yaw = if level > 1e-12 { forward.x.atan2(-forward.z) } else { 0.0 };
    let pitch = forward.y.atan2(level);
    let rolled = self::rotation(yaw, pitch, 0.0).transpose() * rotation.x_axis;
    [yaw, pitch, (-rolled.y).atan2(rolled.x)]
}

impl Pose {
    /// A pose from a position and the angles of [`rotation`], in radians.
    pub fn new(position: DVec3, yaw: f64, pitch: f64, roll: f64) -> Self {
        Self { position, rotation: rotation(yaw, pitch, roll) }
    }

    /// Converts a point of the posed frame to the parent frame.
    pub fn point_to_parent(&self, local: DVec3) -> DVec3 {
        self.rotation * local + self.position
    }

    /// Converts a point of the parent frame to the posed frame.
    pub fn point_to_local(&self, parent: DVec3) -> DVec3 {
        self.rotation.transpose() * (parent - self.position)
    }

    /// Converts a direction (or difference of points) of the posed frame to the parent frame.
    /// Lengths do not change.
    pub fn direction_to_parent(&self, local: DVec3) -> DVec3 {
        self.rotation * local
    }

    /// Converts a direction (or difference of points) of the parent frame to the posed frame.
    /// Lengths do not change.
    pub fn direction_to_local(&self, parent: DVec3) -> DVec3 {
        self.rotation.transpose() * parent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn angles_turn_as_documented() {
        let forward = DVec3::NEG_Z;
        assert!((rotation(FRAC_PI_2, 0.0, 0.0) * forward).distance(DVec3::X) < 1e-15, "yaw turns to the right");
        assert!((rotation(0.0, FRAC_PI_2, 0.0) * forward).distance(DVec3::Y) < 1e-15, "pitch turns up");
        assert!((rotation(0.0, 0.0, FRAC_PI_2) * DVec3::Y).distance(DVec3::X) < 1e-15, "roll is clockwise");
        // Pitch is applied after yaw, about the yawed x axis: the heading stays.
        let aimed = rotation(FRAC_PI_2, 0.5, 0.3) * forward;
        assert!(aimed.distance(DVec3::new(0.5f64.cos(), 0.5f64.sin(), 0.0)) < 1e-15);
    }

    #[test]
    fn angles_are_found_again() {
        let mut random = crate::testing::random::Random::new(5);
        for _ in 0..1000 {
            let [yaw, pitch, roll] = std::array::from_fn(|_| random.range(-3.1, 3.1));
            for turned in [rotation(yaw, pitch, roll), rotation(yaw, FRAC_PI_2, roll), rotation(yaw, -FRAC_PI_2, roll)]
            {
                let [yaw, pitch, roll] = angles(&turned);
                assert!(rotation(yaw, pitch, roll).abs_diff_eq(turned, 1e-12), "{turned}");
            }
        }
        assert_eq!(angles(&DMat3::IDENTITY), [0.0; 3]);
    }

    #[test]
    fn local_and_parent_are_inverse() {
        let pose = Pose::new(DVec3::new(1.0, -2.0, 3.0), 0.4, -1.1, 2.2);
        let point = DVec3::new(-7.0, 0.5, 11.0);
        assert!(pose.point_to_local(pose.point_to_parent(point)).distance(point) < 1e-14);
        assert!(pose.direction_to_local(pose.direction_to_parent(point)).distance(point) < 1e-14);
        assert_eq!(pose.point_to_parent(DVec3::ZERO), pose.position);
        assert!((pose.direction_to_parent(point).length() - point.length()).abs() < 1e-14);
    }
}
