//! The six faces of a cube around the viewer.

use glam::{DMat3, DVec3};

/// Face of the cube, named by the direction in which the viewer sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Face {
    /// −z.
    Front,
    /// +x.
    Right,
    /// −x.
    Left,
    /// +y.
    Up,
    /// −y.
    Down,
    /// +z.
    Back,
}

impl Face {
    /// All faces, in the order in which views are made.
    pub const ALL: [Self; 6] = [Self::Front, Self::Right, Self::Left, Self::Up, Self::Down, Self::Back];

    /// Name in messages and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Right => "right",
            Self::Left => "left",
            Self::Up => "up",
            Self::Down => "down",
            Self::Back => "back",
        }
    }

    /// Returns the rotation from the axes of the viewer to those of the face. The −z axis of the
    /// face goes through its middle. The side faces are upright. The front is at the bottom of the
    /// upper face and at the top of the lower face. All entries are exactly 0, 1 or −1.
    pub fn rotation(self) -> DMat3 {
        let (right, up) = match self {
            Self::Front => (DVec3::X, DVec3::Y),
            Self::Right => (DVec3::Z, DVec3::Y),
            Self::Left => (DVec3::NEG_Z, DVec3::Y),
            Self::Up => (DVec3::X, DVec3::Z),
            Self::Down => (DVec3::X, DVec3::NEG_Z),
            Self::Back => (DVec3::NEG_X, DVec3::Y),
        };
        // The rows are the face's axes; adding zero turns −0 into 0.
        let back = right.cross(up) + DVec3::ZERO;
        DMat3::from_cols(right, up, back).transpose()
    }

    /// Returns the face that a direction (any length, viewer axes) meets. A direction between faces
    /// always gets the same face: front and back come before right and left, and these come before
    /// up and down. The zero vector gets the front.
    pub fn of(direction: DVec3) -> Self {
        let size = direction.abs();
        if size.z >= size.x && size.z >= size.y {
            if direction.z > 0.0 { Self::Back } else { Self::Front }
        } else if size.x >= size.y {
            if direction.x > 0.0 { Self::Right } else { Self::Left }
        } else if direction.y > 0.0 {
            Self::Up
        } else {
            Self::Down
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::pose::rotation;
    use crate::testing::random::Random;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn rotations_are_those_of_a_turned_viewer() {
        let angles = [(0.0, 0.0), (FRAC_PI_2, 0.0), (-FRAC_PI_2, 0.0), (0.0, FRAC_PI_2), (0.0, -FRAC_PI_2), (PI, 0.0)];
        for (face, (yaw, pitch)) in Face::ALL.into_iter().zip(angles) {
            assert!(face.rotation().abs_diff_eq(rotation(yaw, pitch, 0.0).transpose(), 1e-15), "{face:?}");
            assert_eq!(face.rotation().determinant(), 1.0);
        }
    }

    #[test]
    fn every_direction_is_within_its_face() {
        let mut random = Random::new(3);
        for _ in 0..100_000 {
            let direction = random.direction() * 10f64.powf(random.range(-30.0, 30.0));
            let seen = Face::of(direction).rotation() * direction;
            assert!(-seen.z >= seen.x.abs() && -seen.z >= seen.y.abs());
        }
    }

    #[test]
    fn ties_are_settled() {
        assert_eq!(Face::of(DVec3::new(1.0, 1.0, -1.0)), Face::Front);
        assert_eq!(Face::of(DVec3::new(-1.0, 1.0, 1.0)), Face::Back);
        assert_eq!(Face::of(DVec3::new(1.0, -1.0, 0.0)), Face::Right);
        assert_eq!(Face::of(DVec3::ZERO), Face::Front);
    }
}
