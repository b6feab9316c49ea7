//! The opening of a pinhole, symmetric or not.

use glam::{DMat3, DMat4, DVec3, DVec4};

/// The four sides of a perspective view, as tangents: the intersections of its sides with the
/// plane one unit in front of it. `left < right`, `bottom < top`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Frustum {
    /// x of the left side at unit distance.
    pub left: f64,
    /// x of the right side at unit distance.
    pub right: f64,
    /// y of the bottom side at unit distance.
    pub bottom: f64,
    /// y of the top side at unit distance.
    pub top: f64,
}

impl Frustum {
    /// True if all sides are finite.
    pub fn is_finite(&self) -> bool {
        [self.left, self.right, self.bottom, self.top].iter().all(|side| side.is_finite())
    }

    /// Frustum without width and height: only the axis is inside.
    pub const POINT: Self = Self { left: 0.0, right: 0.0, bottom: 0.0, top: 0.0 };

    /// Width at unit distance.
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    /// Height at unit distance.
    pub fn height(&self) -> f64 {
        self.top - self.bottom
    }

    /// Returns the frustum around the axis with these full horizontal and vertical opening angles,
    /// radians in 0…π (exclusive).
    pub fn symmetric(fov_x: f64, fov_y: f64) -> Self {
        let (x, y) = ((0.5 * fov_x).tan(), (0.5 * fov_y).tan());
        Self { left: -x, right: x, bottom: -y, top: y }
    }

    /// Returns the frustum whose sides have these signed angles to the axis, radians in −π/2…π/2
    /// (exclusive), positive to the right and up: `from_angles(-a, a, -b, b)` is symmetric.
    pub fn from_angles(left: f64, right: f64, bottom: f64, top: f64) -> Self {
        Self { left: left.tan(), right: right.tan(), bottom: bottom.tan(), top: top.tan() }
    }

    /// Returns the frustum after a lens shift. The shift is a part of the picture's width and
    /// height, positive to the right and up. The size at unit distance does not change.
    pub fn shifted(&self, shift_x: f64, shift_y: f64) -> Self {
        let (x, y) = (shift_x * self.width(), shift_y * self.height());
        Self { left: self.left + x, right: self.right + x, bottom: self.bottom + y, top: self.top + y }
    }

    /// Returns the smallest frustum that contains both.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            left: self.left.min(other.left),
            right: self.right.max(other.right),
            bottom: self.bottom.min(other.bottom),
            top: self.top.max(other.top),
        }
    }

    /// True if the direction `(tan_x, tan_y, −1)` is inside. A direction on a side is inside, NaN
    /// is not.
    pub fn contains(&self, tan_x: f64, tan_y: f64) -> bool {
        tan_x >= self.left && tan_x <= self.right && tan_y >= self.bottom && tan_y <= self.top
    }

    /// Returns half the width and half the height at unit distance: the reciprocals of A and C of a
    /// projection matrix.
    pub fn half_size(&self) -> (f64, f64) {
        (0.5 * (self.right - self.left), 0.5 * (self.top - self.bottom))
    }

    /// Returns the centre at unit distance: B/A and D/C of a projection matrix.
    pub fn middle(&self) -> (f64, f64) {
        (0.5 * (self.left + self.right), 0.5 * (self.bottom + self.top))
    }

    /// Returns the matrix that maps `(x, y, 1)`, with x and y in −1…1 across the picture (left to
    /// right, bottom to top), to the direction (tangents, −1) in the frustum's own axes. It is the
    /// inverse of [`Self::picture`].
    pub fn rays(&self) -> DMat3 {
        let ((half_x, half_y), (middle_x, middle_y)) = (self.half_size(), self.middle());
        DMat3::from_cols(
            DVec3::new(half_x, 0.0, 0.0),
            DVec3::new(0.0, half_y, 0.0),
            DVec3::new(middle_x, middle_y, -1.0),
        )
    }

    /// Returns the matrix that maps a direction in the frustum's own axes to homogeneous picture
    /// coordinates `(x, y, w)`: x/w and y/w are −1…1 across the picture, and w > 0 is in front.
    pub fn picture(&self) -> DMat3 {
        let ((half_x, half_y), (middle_x, middle_y)) = (self.half_size(), self.middle());
        DMat3::from_cols(
            DVec3::new(1.0 / half_x, 0.0, 0.0),
            DVec3::new(0.0, 1.0 / half_y, 0.0),
            DVec3::new(middle_x / half_x, middle_y / half_y, -1.0),
        )
    }

    /// Returns OpenGL's projection matrix (as of `glFrustum`, NDC depth −1…1) with 0 < `near` <
    /// `far`. `far` may be infinite.
    pub fn projection_matrix(&self, near: f64, far: f64) -> DMat4 {
        let ((half_x, half_y), (middle_x, middle_y)) = (self.half_size(), self.middle());
        let (e, f) = if far.is_infinite() {
            (-1.0, -2.0 * near)
        } else {
            (-(far + near) / (far - near), -2.0 * far * near / (far - near))
        };
        DMat4::from_cols(
            DVec4::new(1.0 / half_x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, 1.0 / half_y, 0.0, 0.0),
            DVec4::new(middle_x / half_x, middle_y / half_y, e, -1.0),
            DVec4::new(0.0, 0.0, f, 0.0),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrix_takes_the_corners_to_the_corners() {
        let frustum = Frustum::from_angles(-0.3, 0.9, -0.5, 0.2).shifted(0.1, -0.25);
        for (far, depth) in [(100.0, 100.0), (f64::INFINITY, 1e12)] {
            let matrix = frustum.projection_matrix(0.5, far);
            let near = matrix * DVec4::new(frustum.left * 0.5, frustum.bottom * 0.5, -0.5, 1.0);
            let end = matrix * DVec4::new(frustum.right * depth, frustum.top * depth, -depth, 1.0);
            assert!((near / near.w).distance(DVec4::new(-1.0, -1.0, -1.0, 1.0)) < 1e-12);
            assert!((end / end.w).distance(DVec4::ONE) < 1e-11);
        }
    }

    #[test]
    fn rays_and_picture_are_inverse_and_shift_is_a_part_of_the_picture() {
        let frustum = Frustum::symmetric(1.2, 0.7).shifted(0.5, -0.5);
        assert!((frustum.left).abs() < 1e-15 && frustum.top.abs() < 1e-15);
        assert!((frustum.rays() * frustum.picture()).abs_diff_eq(DMat3::IDENTITY, 1e-14));
        let corner = frustum.rays() * DVec3::new(1.0, -1.0, 1.0);
        assert!(corner.distance(DVec3::new(frustum.right, frustum.bottom, -1.0)) < 1e-15);
    }

    #[test]
    fn the_sides_belong_to_it() {
        let frustum = Frustum { left: -1.0, right: 2.0, bottom: -3.0, top: 4.0 };
        assert!(frustum.contains(-1.0, 4.0) && frustum.contains(2.0, -3.0));
        assert!(!frustum.contains(2.1, 0.0) && !frustum.contains(0.0, -3.1) && !frustum.contains(f64::NAN, 0.0));
    }
}
