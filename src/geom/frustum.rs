//! The opening of a pinhole, symmetric or not.

/// The four sides of a perspective view, as tangents: the intersections of its sides with the
/// plane one unit in front of it. `left < right`, `bottom < top`.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// Width at unit distance.
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    /// Height at unit distance.
    pub fn height(&self) -> f64 {
        self.top - self.bottom
    }
}
