//! Triangles of an output cut into pieces that lie in one view each.

use crate::correct::passes::facets::{FacetCorner, Facets};
use crate::correct::rough::cells::Triangle;
use crate::geom::Frustum;
use crate::views::ViewPlan;
use glam::{DMat3, DVec3};

/// Texels at the border of a tile that filters may read, but pixels not show.
const BORDER: f64 = 1.5;

/// The directions that a view shows.
pub(super) struct Opening {
    view: usize,
    /// Directions, viewer axes, with a product of at least 0 with each are inside.
    planes: [DVec3; 4],
}

impl Opening {
    /// Returns the opening of a view of a plan, with its guard.
    pub fn of(plan: &ViewPlan, view: usize) -> Self {
        let shown = &plan.views[view];
        let Frustum { left, right, bottom, top, .. } = shown.frustum;
        let border = |opening: f64, texels: u32| BORDER * opening / f64::from(texels.max(1));
        let x = border(right - left, shown.tile.width);
        let y = border(top - bottom, shown.tile.height);
        let to_viewer: DMat3 = shown.rotation.transpose();
        let planes = [
            DVec3::new(1.0, 0.0, left + x),
            DVec3::new(-1.0, 0.0, -(right - x)),
            DVec3::new(0.0, 1.0, bottom + y),
            DVec3::new(0.0, -1.0, -(top - y)),
        ];
        Self { view, planes: planes.map(|plane| to_viewer * plane) }
    }
}

#[cfg(test)]
impl Opening {
    /// True if the view shows a direction.
    pub fn shows(&self, direction: DVec3) -> bool {
        self.planes.iter().all(|plane| plane.dot(direction) >= 0.0)
    }
}

/// Returns the pieces of triangles in each view that has some. What several views show is in the
/// first one.
pub(super) fn in_views(triangles: &[Triangle], openings: &[Opening]) -> Vec<(usize, Facets)> {
    let mut all: Vec<(usize, Facets)> =
        openings.iter().map(|opening| (opening.view, Facets { is_rough: true, ..Facets::default() })).collect();
    for triangle in triangles {
        let mut left = vec![triangle.to_vec()];
        for (opening, (_, facets)) in openings.iter().zip(&mut all) {
            let mut beyond = Vec::new();
            for piece in left {
                let inside = divide(piece, &opening.planes, &mut beyond);
                add(facets, &inside);
            }
            left = beyond;
            if left.is_empty() {
                break;
            }
        }
    }
    all.retain(|(_, facets)| !facets.triangles.is_empty());
    all
}

/// Adds a convex polygon.
fn add(facets: &mut Facets, polygon: &[FacetCorner]) {
    if polygon.len() < 3 {
        return;
    }
    let first = facets.corners.len() as u32;
    facets.corners.extend_from_slice(polygon);
    facets.triangles.extend((1..polygon.len() as u32 - 1).map(|corner| [first, first + corner, first + corner + 1]));
}

/// Returns the part of a convex polygon inside of all planes, and adds the other parts to `beyond`.
fn divide(polygon: Vec<FacetCorner>, planes: &[DVec3; 4], beyond: &mut Vec<Vec<FacetCorner>>) -> Vec<FacetCorner> {
    let depth = |plane: &DVec3, corner: &FacetCorner| plane.dot(corner.direction);
    if planes.iter().any(|plane| polygon.iter().all(|corner| depth(plane, corner) <= 0.0)) {
        beyond.push(polygon);
        return Vec::new();
    }
    let mut inside = polygon;
    for plane in planes {
        if inside.iter().all(|corner| depth(plane, corner) >= 0.0) {
            continue;
        }
        let outside = cut(&inside, -*plane);
        inside = cut(&inside, *plane);
        if outside.len() > 2 {
            beyond.push(outside);
        }
    }
    inside
}

/// Returns the part of a convex polygon with products of at least 0 (Sutherland & Hodgman 1974).
/// Directions and weights are linear over the output.
fn cut(polygon: &[FacetCorner], plane: DVec3) -> Vec<FacetCorner> {
    let mut part = Vec::with_capacity(polygon.len() + 1);
    for (from, to) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let (here, next) = (plane.dot(from.direction), plane.dot(to.direction));
        if here >= 0.0 {
            part.push(*from);
        }
        if (here < 0.0 && next > 0.0) || (here > 0.0 && next < 0.0) {
            let along = here / (here - next);
            part.push(FacetCorner {
                place: from.place + (to.place - from.place) * along,
                direction: from.direction + (to.direction - from.direction) * along,
                weight: from.weight + (to.weight - from.weight) * along,
            });
        }
    }
    if part.len() < 3 { Vec::new() } else { part }
}
