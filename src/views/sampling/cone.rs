//! The cone of directions that a view serves, and the test whether a small patch of directions is
//! inside, outside or on the border.
//!
//! A view's part, like a projector's picture, is a convex cone with four sides. A block of pixels
//! shows a small curved patch. The patch departs from the flat quadrilateral of its corners by at
//! most about its diameter squared. So if all corners lie deeper inside than that, the whole patch
//! lies inside. If all corners lie farther beyond one side than that, the whole patch lies beyond
//! it.

use crate::geom::Frustum;
use crate::views::view_plan::View;
use glam::{DMat3, DVec3};

/// Patches wider than this (radians) are not judged by their corners.
pub(crate) const WIDEST: f64 = 0.2;

/// A convex cone with four sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    /// Outer axes → the cone's axes, in which it looks along −z.
    axes: DMat3,
    /// Inward unit normals of the left, right, bottom and top side, in the cone's axes.
    normals: [DVec3; 4],
    /// True if the cone has no sides: all directions are deep inside.
    whole: bool,
}

/// Position of a patch relative to a cone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    /// The whole patch is inside.
    Inside,
    /// The whole patch is outside.
    Outside,
    /// The corners do not decide.
    Unclear,
}

impl Cone {
    /// Makes the cone with the given axes (outer axes → its own) and opening.
    pub fn new(axes: DMat3, opening: &Frustum) -> Self {
        let normals = [
            DVec3::new(1.0, 0.0, opening.left),
            DVec3::new(-1.0, 0.0, -opening.right),
            DVec3::new(0.0, 1.0, opening.bottom),
            DVec3::new(0.0, -1.0, -opening.top),
        ];
        Self { axes, normals: normals.map(DVec3::normalize_or_zero), whole: false }
    }

    /// Returns the cone of the directions that `view` serves; all directions for the picture of an
    /// output.
    pub fn of(view: &View) -> Self {
        Self { whole: view.curved.is_some(), ..Self::new(view.rotation, &view.owned) }
    }

    /// Returns the inward unit normals of the left, right, bottom and top side, in the outer axes.
    pub fn sides(&self) -> [DVec3; 4] {
        self.normals.map(|normal| self.axes.transpose() * normal)
    }

    /// Returns the depth of a direction inside each side; radians near it, for a direction of unit
    /// length.
    pub fn depths(&self, direction: DVec3) -> [f64; 4] {
        let local = self.axes * direction;
        self.normals.map(|normal| if self.whole { f64::INFINITY } else { normal.dot(local) })
    }

    /// Returns directions in the cone's own axes.
    pub fn localized(&self, directions: &[DVec3; 4]) -> [DVec3; 4] {
        directions.map(|direction| self.axes * direction)
    }

    /// True if a direction lies inside.
    pub fn contains(&self, direction: DVec3) -> bool {
        self.depths(direction).iter().all(|&depth| depth >= 0.0)
    }

    /// Returns the relation of a patch to the cone. The patch has these corners, all of unit
    /// length, and departs from their quadrilateral by `departure` at most.
    pub fn relation(&self, corners: &[DVec3; 4], departure: f64) -> Relation {
        let depths = corners.map(|corner| self.depths(corner));
        let mut inside = true;
        for side in 0..4 {
            let of_side = depths.map(|depths| depths[side]);
            if of_side.iter().all(|&depth| depth < -departure) {
                return Relation::Outside;
            }
            inside &= of_side.iter().all(|&depth| depth > departure);
        }
        if inside { Relation::Inside } else { Relation::Unclear }
    }
}

/// Returns the distance across a patch with the corners upper left, upper right, lower left, lower
/// right.
pub(crate) fn diameter(corners: &[DVec3; 4]) -> f64 {
    corners[0].distance(corners[3]).max(corners[1].distance(corners[2]))
}
