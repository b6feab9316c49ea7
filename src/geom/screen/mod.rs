//! Screens: surfaces that projectors light and that a viewer looks at.
//!
//! Every shape has axes of its own (+y along its pole or axis, −z its front). Through [`Surface`]
//! it returns the point that a ray lights. All is computed in f64; hits are off by about 1e-15
//! times (1 + distance of the origin / size). The only f32 step comes later, when a table of
//! directions is written. Its error is 6e-8 of the distance from the middle of an output's
//! directions.

mod closed;
mod cone;
mod ellipsoid;
mod mesh;
mod plane;
mod region;

pub use closed::{Bounds, ClosedForm, ClosedSurface, HalfSpace, Join, Sides};
pub use cone::Cone;
pub use ellipsoid::Ellipsoid;
pub use mesh::{Faces, MOST_TRIANGLES, Mesh, MeshProblem, Triangle};
pub use plane::Plane;
pub use region::Region;

use super::Pose;
use glam::DVec3;
use std::sync::Arc;

/// End of a ray on a screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The point.
    pub point: DVec3,
    /// Unit normal of the screen there, on the side that is lit.
    pub normal: DVec3,
}

/// A line along the rim of a screen: 0…1 → point.
pub type Rim<'a> = Box<dyn Fn(f64) -> DVec3 + 'a>;

/// A contour line: position along it, 0…1, and distance from it → point. The distance is measured
/// across the line, in radii, towards the part that is lit from the point of view.
pub type Contour<'a> = Box<dyn Fn(f64, f64) -> DVec3 + 'a>;

/// Distance of a rim's line from the edge of the screen, as a part of the extent. Because of it,
/// rays to points of the line hit the screen despite rounding.
const INSET: f64 = 1e-9;

/// A surface in axes of its own.
pub trait Surface {
    /// Returns the point at which the ray from `origin` along `direction` (any length but 0) lights
    /// the screen; `None` if it does not, and for directions that are zero or not finite.
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit>;

    /// Returns the same on the surface of which the screen is a part: not cut at the screen's rim.
    /// A shape without such a surface returns the result of [`Self::hit`].
    fn unbounded_hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit>;

    /// Lines along which the screen ends, just within it.
    fn rims(&self) -> Vec<Rim<'_>>;

    /// Returns a line close to the horizon of the screen's endless extension, if it has one.
    fn horizon(&self) -> Option<Rim<'_>> {
        None
    }

    /// Returns the contour lines of the surface as seen from a point outside: rays from the point
    /// graze the surface there. There are none from inside, and for shapes without curvature.
    fn contours(&self, _from: DVec3) -> Vec<Contour<'_>> {
        Vec::new()
    }

    /// A length for tolerances: about half the greatest extent of the screen, > 0.
    fn size(&self) -> f64;
}

/// The shape of a screen.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum Shape {
    /// A part of a sphere or an ellipsoid, lit from inside.
    Ellipsoid(Ellipsoid),
    /// A part of a cylinder or a cone, lit from inside.
    Cone(Cone),
    /// A flat rectangle, lit from either side.
    Plane(Plane),
    /// Triangles.
    Mesh(Arc<Mesh>),
}

/// A screen with a pose in the dome's axes.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Screen {
    /// The shape's own axes → dome axes.
    pub pose: Pose,
    /// The shape.
    pub shape: Shape,
}

impl Screen {
    fn surface(&self) -> &dyn Surface {
        match &self.shape {
            Shape::Ellipsoid(ellipsoid) => ellipsoid,
            Shape::Cone(cone) => cone,
            Shape::Plane(plane) => plane,
            Shape::Mesh(mesh) => mesh.as_ref(),
        }
    }

    fn to_dome(&self, hit: Hit) -> Hit {
        Hit { point: self.pose.point_to_parent(hit.point), normal: self.pose.direction_to_parent(hit.normal) }
    }

    /// [`Surface::hit`] in dome axes.
    pub fn hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let (origin, direction) = (self.pose.point_to_local(origin), self.pose.direction_to_local(direction));
        self.surface().hit(origin, direction).map(|hit| self.to_dome(hit))
    }

    /// [`Surface::unbounded_hit`] in dome axes.
    pub fn unbounded_hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let (origin, direction) = (self.pose.point_to_local(origin), self.pose.direction_to_local(direction));
        self.surface().unbounded_hit(origin, direction).map(|hit| self.to_dome(hit))
    }

    /// [`Surface::rims`] in dome axes.
    pub fn rims(&self) -> Vec<Rim<'_>> {
        let mut rims: Vec<Rim<'_>> = Vec::new();
        for rim in self.surface().rims() {
            rims.push(Box::new(move |part| self.pose.point_to_parent(rim(part))));
        }
        rims
    }

    /// [`Surface::horizon`] in dome axes.
    pub fn horizon(&self) -> Option<Rim<'_>> {
        let horizon = self.surface().horizon()?;
        Some(Box::new(move |part| self.pose.point_to_parent(horizon(part))))
    }

    /// [`Surface::contours`] in dome axes.
    pub fn contours(&self, from: DVec3) -> Vec<Contour<'_>> {
        let mut contours: Vec<Contour<'_>> = Vec::new();
        for contour in self.surface().contours(self.pose.point_to_local(from)) {
            contours.push(Box::new(move |part, inset| self.pose.point_to_parent(contour(part, inset))));
        }
        contours
    }

    /// [`Surface::size`], metres.
    pub fn size(&self) -> f64 {
        self.surface().size()
    }

    /// Mean number of triangles that a ray is tested with; 0 for a screen without triangles.
    pub fn tested(&self) -> f64 {
        match &self.shape {
            Shape::Mesh(mesh) => mesh.tested(),
            _ => 0.0,
        }
    }

    /// True if the screen is smooth between its rims. Then its map changes smoothly across a
    /// picture.
    pub fn is_smooth(&self) -> bool {
        !matches!(self.shape, Shape::Mesh(_))
    }
}

/// Returns `from` and `to`, both moved inwards by the rims' inset.
fn inset(from: f64, to: f64) -> (f64, f64) {
    (from + INSET * (to - from), to - INSET * (to - from))
}

/// Returns `direction` scaled to unit length; `None` if it is zero or not finite.
fn unit(direction: DVec3) -> Option<DVec3> {
    let scale = direction.abs().max_element();
    (scale > 0.0 && scale.is_finite()).then(|| (direction / scale).normalize())
}

#[cfg(test)]
mod tests;
