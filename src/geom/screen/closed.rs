//! Screens that have a closed form: their surface, and the part of it that is screen.

use super::{Shape, region::onward};
use crate::geom::Quadric;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Surface whose intersection with a ray needs one square root at most.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub enum ClosedSurface {
    /// Lit from inside.
    Quadric(Quadric),
    /// The plane z = 0, lit from either side.
    Plane,
}

/// The points with `normal·p ≥ distance`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct HalfSpace {
    /// Unit normal. 0 with a distance < 0 means all points; then a pixel's form only tells whether
    /// the pixel has a point.
    pub normal: DVec3,
    /// Distance from the origin.
    pub distance: f64,
}

impl HalfSpace {
    /// Returns the depth of a point in it, metres.
    fn depth(&self, point: DVec3) -> f64 {
        if self.normal == DVec3::ZERO { f64::INFINITY } else { self.normal.dot(point) - self.distance }
    }
}

/// Combination of two half-spaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum Join {
    /// Points in both.
    Both,
    /// Points in one of them, or in both.
    Either,
}

/// Two half-spaces.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Sides {
    /// The half-spaces.
    pub spaces: [HalfSpace; 2],
    /// Their combination.
    pub join: Join,
}

/// The part of a surface that is screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Bounds {
    /// Half-spaces; the screen is in all of them.
    pub limits: [Option<HalfSpace>; 3],
    /// Two further half-spaces; the screen is in their combination.
    pub sides: Option<Sides>,
}

impl Bounds {
    /// True if a point of the surface is on the screen.
    pub fn contain(&self, point: DVec3) -> bool {
        self.hold_all(&[point; 4], 0.0) == Some(true)
    }

    /// True if all points of the surface that are no farther than `reach` from each of `points` are
    /// on the screen; `None` if this cannot be decided.
    pub fn hold_all(&self, points: &[DVec3; 4], reach: f64) -> Option<bool> {
        let holds = |space: &HalfSpace| {
            let depths = points.map(|point| space.depth(point));
            let least = depths.iter().copied().fold(f64::INFINITY, f64::min);
            let greatest = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            match () {
                () if least >= reach => Some(true),
                () if greatest < -reach => Some(false),
                () => None,
            }
        };
        let sides = self.sides.as_ref().map(|sides| match (sides.join, sides.spaces.each_ref().map(holds)) {
            (Join::Both, [a, b]) => both(a, b),
            (Join::Either, [a, b]) => both(a.map(|a| !a), b.map(|b| !b)).map(|neither| !neither),
        });
        self.limits.iter().flatten().map(holds).chain(sides).fold(Some(true), both)
    }

    /// True if all of the surface is screen.
    pub fn is_all(&self) -> bool {
        *self == Self::default()
    }
}

/// Returns the conjunction of both; `None` if it is unknown.
fn both(a: Option<bool>, b: Option<bool>) -> Option<bool> {
    match (a, b) {
        (Some(false), _) | (_, Some(false)) => Some(false),
        (Some(true), Some(true)) => Some(true),
        _ => None,
    }
}

/// A screen, in its own axes, as a part of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedForm {
    /// The origin of the surface's axes, which are parallel to the screen's.
    pub middle: DVec3,
    /// The surface.
    pub surface: ClosedSurface,
    /// The part that is screen, in the surface's axes.
    pub bounds: Bounds,
}

impl Shape {
    /// Returns the surface of which the shape is a part; `None` for meshes, and for a cap of an
    /// ellipsoid with three different half axes, whose rim does not lie in a plane.
    pub fn closed_form(&self) -> Option<ClosedForm> {
        let above = |height: f64| Some(HalfSpace { normal: DVec3::Y, distance: height });
        let below = |height: f64| Some(HalfSpace { normal: DVec3::NEG_Y, distance: -height });
        match self {
            Self::Ellipsoid(ellipsoid) => {
                let (radii, region) = (ellipsoid.radii, ellipsoid.region);
                let limit = (region.polar < PI).then_some(region.polar.sin_cos());
                if limit.is_some() && radii.x != radii.z {
                    return None;
                }
                // Height at which a line from the centre at the rim's polar angle meets the
                // ellipsoid.
                let rim = limit.and_then(|(sine, cosine)| above(cosine / (sine / radii.x).hypot(cosine / radii.y)));
                let bounds = Bounds { limits: [rim, None, None], sides: around(region.azimuth) };
                Some(ClosedForm {
                    middle: DVec3::ZERO,
                    surface: ClosedSurface::Quadric(Quadric::ellipsoid(radii)),
                    bounds,
                })
            }
            Self::Cone(cone) => {
                let slope = cone.slope();
                let ahead = HalfSpace { normal: DVec3::ZERO, distance: -1.0 };
                let (apex, quadric, ahead) = if slope == 0.0 {
                    (0.0, Quadric::cylinder(cone.radii[0]), None)
                } else {
                    (cone.heights[0] - cone.radii[0] / slope, Quadric::cone(slope), Some(ahead))
                };
                let [bottom, top] = cone.heights.map(|height| height - apex);
                let bounds = Bounds { limits: [above(bottom), below(top), ahead], sides: around(cone.azimuth) };
                Some(ClosedForm { middle: DVec3::Y * apex, surface: ClosedSurface::Quadric(quadric), bounds })
            }
            Self::Plane(plane) => {
                let half = 0.5 * plane.size;
                let space = |normal: DVec3, half: f64| HalfSpace { normal, distance: -half };
                let across = [space(DVec3::X, half.x), space(DVec3::NEG_X, half.x)];
                let sides = Some(Sides { spaces: across, join: Join::Both });
                let bounds = Bounds { limits: [above(-half.y), below(half.y), None], sides };
                Some(ClosedForm { middle: DVec3::ZERO, surface: ClosedSurface::Plane, bounds })
            }
            Self::Mesh(_) => None,
        }
    }
}

/// Returns the sides of a range of azimuth around the y axis; `None` if it goes all around.
fn around(azimuth: Option<[f64; 2]>) -> Option<Sides> {
    let [from, to] = azimuth.filter(|[from, to]| to - from < TAU)?;
    // The first half-space goes half a turn on from the start, the second half a turn back from the
    // end.
    let spaces = [onward(from), -onward(to)].map(|along| HalfSpace { normal: along, distance: 0.0 });
    Some(Sides { spaces, join: if to - from <= PI { Join::Both } else { Join::Either } })
}
