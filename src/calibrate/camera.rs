//! A camera in the dome, with a lens that is not known.

use crate::geom::Pose;
use glam::{DMat3, DMat4, DQuat, DVec2, DVec3, DVec4};

/// Kinds of lenses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraLens {
    /// The distance from the centre is f·(θ + k₁θ³ + k₂θ⁵ + k₃θ⁷), θ being the angle from the axis
    /// (Kannala and Brandt 2006).
    Fisheye,
    /// The distance is f·(t + k₁t³ + k₂t⁵) with t = tan θ (Brown 1966).
    Pinhole,
}

impl CameraLens {
    /// Number of coefficients.
    pub fn terms(self) -> usize {
        match self {
            Self::Fisheye => 3,
            Self::Pinhole => 2,
        }
    }
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Position and rotation in dome axes.
    pub pose: Pose,
    /// Kind of its lens.
    pub lens: CameraLens,
    /// Focal length f, pixels.
    pub focal: f64,
    /// Place of the axis in the photograph, pixels from the top left.
    pub center: DVec2,
    /// Coefficients k₁, k₂, k₃.
    pub radial: [f64; 3],
    /// Width and height of the photograph, pixels.
    pub size: (u32, u32),
}

/// Numbers of a camera without the coefficients of its lens: position, rotation, focal length,
/// centre.
const PLAIN: usize = 9;

impl Camera {
    /// Returns a camera with an ideal lens, whose axis is in the middle of the photograph.
    pub fn new(pose: Pose, lens: CameraLens, focal: f64, size: (u32, u32)) -> Self {
        let center = 0.5 * DVec2::new(f64::from(size.0), f64::from(size.1));
        Self { pose, lens, focal, center, radial: [0.0; 3], size }
    }

    /// Number of parameters of [`Self::moved`].
    pub fn parameters(&self) -> usize {
        PLAIN + self.lens.terms()
    }

    /// Returns the camera with differences from this one, all of them free. Lengths are in `unit`
    /// metres.
    pub fn moved(&self, parameters: &[f64], unit: f64) -> Self {
        let mut moved = self.clone();
        let Some((&[x, y, z, a, b, c, focal, right, down], radial)) = parameters.split_first_chunk::<PLAIN>() else {
            return moved;
        };
        moved.pose.position += unit * DVec3::new(x, y, z);
        moved.pose.rotation *= DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(a, b, c)));
        moved.focal *= focal.exp();
        moved.center += f64::from(self.size.0) * DVec2::new(right, down);
        moved.radial.iter_mut().zip(radial).for_each(|(own, change)| *own += change);
        moved
    }

    /// Place at which a point appears, perhaps beside the photograph; `None` behind the camera.
    pub fn place(&self, point: DVec3) -> Option<DVec2> {
        let local = self.pose.point_to_local(point);
        let across = DVec2::new(local.x, -local.y);
        let length = across.length();
        let [k1, k2, k3] = self.radial;
        let (value, third) = match self.lens {
            CameraLens::Fisheye => (length.atan2(-local.z), k3),
            CameraLens::Pinhole if local.z < 0.0 => (length / -local.z, 0.0),
            CameraLens::Pinhole => return None,
        };
        let square = value * value;
        let radius = self.focal * value * (1.0 + square * (k1 + square * (k2 + square * third)));
        let towards = if length > 0.0 { across / length } else { DVec2::ZERO };
        let place = self.center + towards * radius;
        place.is_finite().then_some(place)
    }

    /// Direction, in camera axes, of a place in the photograph, for a lens without coefficients;
    /// `None` behind the camera.
    pub fn ideal_ray(&self, place: DVec2) -> Option<DVec3> {
        let across = (place - self.center) * DVec2::new(1.0, -1.0) / self.focal;
        let radius = across.length();
        let angle = match self.lens {
            CameraLens::Fisheye => radius,
            CameraLens::Pinhole => radius.atan(),
        };
        let towards = if radius > 0.0 { across / radius } else { DVec2::ZERO };
        (angle < std::f64::consts::PI).then(|| (towards * angle.sin()).extend(-angle.cos()))
    }
}

/// Returns the rotation that takes the first of each pair of directions to the second with the
/// least squared error: Davenport's method (1968). The eigenvector is found by squaring the matrix.
pub fn rotation(pairs: &[(DVec3, DVec3)]) -> DMat3 {
    let mut outer = DMat3::ZERO;
    let mut axis = DVec3::ZERO;
    for (from, to) in pairs {
        outer += DMat3::from_cols(*to * from.x, *to * from.y, *to * from.z);
        axis += from.cross(*to);
    }
    let trace = outer.x_axis.x + outer.y_axis.y + outer.z_axis.z;
    let symmetric = outer + outer.transpose() - DMat3::from_diagonal(DVec3::splat(trace));
    // Makes all eigenvalues positive.
    let shift = DVec4::splat(2.0 * pairs.len().max(1) as f64);
    let mut matrix = DMat4::from_cols(
        symmetric.x_axis.extend(axis.x),
        symmetric.y_axis.extend(axis.y),
        symmetric.z_axis.extend(axis.z),
        axis.extend(trace),
    ) + DMat4::from_diagonal(shift);
    for _ in 0..40 {
        let size = (0..4).map(|column| matrix.col(column).abs().max_element()).fold(0.0, f64::max);
        matrix *= 1.0 / size.max(f64::MIN_POSITIVE);
        matrix = matrix * matrix;
    }
    let columns = (0..4).map(|column| matrix.col(column));
    let vector = columns.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(DVec4::W);
    let vector = vector.try_normalize().unwrap_or(DVec4::W);
    DMat3::from_quat(DQuat::from_vec4(vector))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;

    #[test]
    fn rotations_are_found() {
        let mut random = Random::new(91);
        for _ in 0..50 {
            let right = random.rotation();
            let from: Vec<DVec3> = (0..9).map(|_| random.direction()).collect();
            let pairs: Vec<_> = from.iter().map(|from| (*from, right * *from)).collect();
            assert!(rotation(&pairs).abs_diff_eq(right, 1e-9));
        }
        assert!(rotation(&[]).is_finite());
    }

    #[test]
    fn places_are_those_of_the_formulas() {
        let pose = Pose::new(DVec3::new(0.0, 1.0, 0.0), 0.0, 0.0, 0.0);
        let fisheye = Camera::new(pose, CameraLens::Fisheye, 100.0, (640, 480));
        let right = fisheye.place(DVec3::new(3.0, 1.0, 0.0)).expect("seen");
        assert!(right.distance(DVec2::new(320.0 + 50.0 * std::f64::consts::PI, 240.0)) < 1e-12);
        let pinhole = Camera::new(pose, CameraLens::Pinhole, 100.0, (640, 480));
        let up = pinhole.place(DVec3::new(0.0, 3.0, -2.0)).expect("seen");
        assert!(up.distance(DVec2::new(320.0, 140.0)) < 1e-12);
        assert_eq!(pinhole.place(DVec3::Z), None);
        for camera in [fisheye, pinhole] {
            let ray = camera.ideal_ray(DVec2::new(400.0, 100.0)).expect("in front");
            let back = camera.place(camera.pose.point_to_parent(ray)).expect("seen");
            assert!(back.distance(DVec2::new(400.0, 100.0)) < 1e-11);
        }
    }
}
