//! The rays of a pinhole in front of a screen that has a closed form.

use crate::geom::QuadraticForm;
use crate::geom::quadratic::linear_at;
use crate::geom::screen::{Bounds, ClosedSurface, HalfSpace, Join, Sides};
use glam::{DAffine3, DMat3, DVec3};

/// The rays `origin + t·rays·(x, y, 1)` of a pinhole's pixels (x and y in −1…1) and a surface,
/// all in the surface's own axes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PinholeRays {
    /// Origin of the rays.
    pub origin: DVec3,
    /// Pixel `(x, y, 1)` → ray.
    pub rays: DMat3,
    /// Surface that they meet.
    pub surface: ClosedSurface,
}

impl PinholeRays {
    /// Returns the form of the direction in which an eye sees each pixel's point, turned by
    /// `target`.
    pub fn seen_from(&self, eye: DVec3, target: DMat3) -> QuadraticForm {
        self.mapped(DAffine3 { matrix3: target, translation: -(target * eye) })
    }

    /// Returns a form with one component for each half-space: ≥ 0 if a pixel's point is in the
    /// half-space. The components of missing half-spaces are 0.
    pub fn within(&self, spaces: [Option<HalfSpace>; 3]) -> QuadraticForm {
        let normals = spaces.map(|space| space.map_or(DVec3::ZERO, |space| space.normal));
        let distances = spaces.map(|space| space.map_or(0.0, |space| space.distance));
        let rows = DMat3::from_cols(normals[0], normals[1], normals[2]);
        self.mapped(DAffine3 { matrix3: rows.transpose(), translation: -DVec3::from_array(distances) })
    }

    fn mapped(&self, map: DAffine3) -> QuadraticForm {
        match &self.surface {
            ClosedSurface::Quadric(quadric) => QuadraticForm::on(self.origin, self.rays, quadric, map),
            ClosedSurface::Plane => QuadraticForm::on_plane(self.origin, self.rays, map),
        }
    }

    /// Returns the value of one of these forms at a pixel, as [`QuadraticForm::evaluate`] does,
    /// also for double cones: `None` if the ray does not meet the half that exists.
    pub fn evaluate(&self, form: &QuadraticForm, x: f64, y: f64) -> Option<DVec3> {
        match &self.surface {
            ClosedSurface::Quadric(quadric) if !quadric.is_convex() => {
                // offset·a + L·(√D − b), times the factor (√D + b)/a. The sign of the factor tells
                // whether the point is ahead.
                let ray = self.rays * DVec3::new(x, y, 1.0);
                let factor = quadric.product(self.origin, ray) + form.discriminant(x, y).sqrt();
                let linear = DVec3::from_array(form.l.map(|row| linear_at(&row, x, y)));
                (factor > 0.0).then(|| form.offset * factor + linear * quadric.depth(self.origin))
            }
            _ => form.evaluate(x, y),
        }
    }

    /// True if no pixel (x and y in −1…1) has the surface behind it. Then the forms have no false
    /// hits, except those of double cones, which [`crate::geom::screen::Bounds`] exclude. True for
    /// every pinhole inside the surface. For one outside, or in front of a plane, true if the whole
    /// picture looks towards the surface.
    pub fn looks_at_it(&self) -> bool {
        let towards = |ray: DVec3| match &self.surface {
            ClosedSurface::Quadric(quadric) => quadric.is_convex() && quadric.product(self.origin, ray) < 0.0,
            ClosedSurface::Plane => self.origin.z * ray.z < 0.0,
        };
        let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        // Both are linear in the pixel: if the corners are ahead, all pixels are.
        let ahead = || corners.into_iter().all(|(x, y)| towards(self.rays * DVec3::new(x, y, 1.0)));
        self.is_inside(1.0) || ahead()
    }

    /// True if the pinhole is inside a surface that has an inside, at most at the fraction `part`
    /// of the way from the centre or the axis to the surface.
    pub fn is_inside(&self, part: f64) -> bool {
        matches!(&self.surface, ClosedSurface::Quadric(quadric) if quadric.contains(self.origin, part))
    }

    /// Returns the point that the ray of a pixel lights, in the surface's own axes; `None` if it
    /// lights none. The pinhole may be inside or outside.
    pub fn hit(&self, x: f64, y: f64) -> Option<DVec3> {
        let ray = self.rays * DVec3::new(x, y, 1.0);
        let distance = match &self.surface {
            ClosedSurface::Plane => -self.origin.z / ray.z,
            ClosedSurface::Quadric(quadric) => {
                let only = DMat3::from_cols(DVec3::ZERO, DVec3::ZERO, ray);
                let form = QuadraticForm::on(self.origin, only, quadric, DAffine3::IDENTITY);
                if quadric.is_convex() && !self.is_inside(1.0) {
                    return Some(form.evaluate(0.0, 0.0)? / quadric.product(ray, ray));
                }
                quadric.depth(self.origin) / (quadric.product(self.origin, ray) + form.discriminant(0.0, 0.0).sqrt())
            }
        };
        (distance > 0.0 && distance.is_finite()).then(|| self.origin + ray * distance)
    }
}

/// Forms that tell whether the point of a pixel is on the part of its surface that is screen.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct RimForms {
    /// Form whose three components are all ≥ 0 on the screen.
    pub limits: QuadraticForm,
    /// Form of which the first two components, both or either, are ≥ 0 on the screen.
    pub sides: Option<(QuadraticForm, Join)>,
}

impl RimForms {
    /// The forms of `bounds`.
    pub fn of(pinhole: &PinholeRays, bounds: &Bounds) -> Self {
        let side = |sides: &Sides| (pinhole.within([Some(sides.spaces[0]), Some(sides.spaces[1]), None]), sides.join);
        Self { limits: pinhole.within(bounds.limits), sides: bounds.sides.as_ref().map(side) }
    }

    /// True if a pixel's point is on the screen. `pinhole` is the one of these forms.
    pub fn allow(&self, pinhole: &PinholeRays, x: f64, y: f64) -> bool {
        let holds = |form: &QuadraticForm| pinhole.evaluate(form, x, y).map(|value| value.cmpge(DVec3::ZERO));
        let within = holds(&self.limits).is_some_and(|limits| limits.all());
        within
            && self.sides.as_ref().is_none_or(|(form, join)| match (holds(form), join) {
                (Some(sides), Join::Both) => sides.x && sides.y,
                (Some(sides), Join::Either) => sides.x || sides.y,
                (None, _) => false,
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::screen::{ClosedForm, Cone, Ellipsoid, Plane, Region, Shape};
    use crate::geom::{Frustum, Pose, Screen};
    use crate::testing::random::Random;
    use glam::DVec2;
    use std::f64::consts::{PI, TAU};

    fn shapes(random: &mut Random) -> [Shape; 5] {
        let azimuth = (random.range(0.0, 1.0) < 0.7).then(|| {
            let from = random.range(-PI, PI);
            [from, from + random.range(0.5, TAU)]
        });
        let polar = if random.range(0.0, 1.0) < 0.3 { PI } else { random.range(0.5, 3.0) };
        let heights = [random.range(-4.0, -1.0), random.range(1.0, 4.0)];
        let flattened = DVec3::new(4.0, random.range(2.0, 6.0), 4.0);
        [
            Shape::Ellipsoid(Ellipsoid { radii: flattened, region: Region { polar, azimuth } }),
            Shape::Ellipsoid(Ellipsoid { radii: DVec3::new(3.0, 5.0, 4.0), region: Region { polar: PI, azimuth } }),
            Shape::Cone(Cone { heights, radii: [3.0, 3.0], azimuth }),
            Shape::Cone(Cone { heights, radii: [random.range(2.0, 5.0), random.range(0.0, 4.0)], azimuth }),
            Shape::Plane(Plane { size: DVec2::new(random.range(2.0, 8.0), random.range(2.0, 8.0)) }),
        ]
    }

    /// Compares with the screens' own hits, which are separate code.
    #[test]
    fn forms_and_bounds_agree_with_traced_rays() {
        let mut random = Random::new(91);
        let (mut lit, mut dark) = ([0; 5], [0; 5]);
        // The test must notice an eye that is a millimetre off.
        let mut noticed = 0.0f64;
        for _ in 0..400 {
            for (index, shape) in shapes(&mut random).into_iter().enumerate() {
                let Some(closed) = shape.closed_form() else { panic!("{shape:?} has one") };
                let ClosedForm { middle, surface, bounds } = closed;
                let screen = Screen { pose: Pose::new(DVec3::ZERO, 0.0, 0.0, 0.0), shape };
                let inside = matches!(surface, ClosedSurface::Quadric(_));
                let place = random.direction() * random.range(0.0, if inside { 1.2 } else { 9.0 });
                let (yaw, pitch) = (random.range(-PI, PI), random.range(-1.5, 1.5));
                let rays = Pose::new(place, yaw, pitch, 0.3).rotation * Frustum::symmetric(0.8, 0.6).rays();
                let pinhole = PinholeRays { origin: place - middle, rays, surface };
                if !pinhole.looks_at_it() {
                    continue;
                }
                let (eye, target) = (random.vector(-1.0, 1.0), random.rotation());
                let form = pinhole.seen_from(eye - middle, target);
                let aside = pinhole.seen_from(eye - middle + DVec3::X * 1e-3, target);
                let rims = RimForms::of(&pinhole, &bounds);
                for _ in 0..20 {
                    let (x, y) = (random.range(-1.0, 1.0), random.range(-1.0, 1.0));
                    let traced = screen.hit(place, rays * DVec3::new(x, y, 1.0)).map(|hit| hit.point);
                    let point = pinhole.hit(x, y);
                    // For a point on a rim, rounding decides on which side it is.
                    if point.is_some_and(|point| bounds.hold_all(&[point; 4], 1e-9).is_none()) {
                        continue;
                    }
                    let point = point.filter(|point| bounds.contain(*point));
                    assert_eq!(traced.is_some(), point.is_some(), "{screen:?} {pinhole:?} {x} {y}");
                    assert_eq!(rims.allow(&pinhole, x, y), point.is_some(), "{screen:?} {pinhole:?} {x} {y}");
                    let (Some(traced), Some(point)) = (traced, point) else {
                        dark[index] += 1;
                        continue;
                    };
                    lit[index] += 1;
                    assert!(traced.distance(point + middle) < 1e-9, "{screen:?}: {traced} {point}");
                    let seen = (target * (traced - eye)).normalize();
                    let shown = pinhole.evaluate(&form, x, y).unwrap_or_default().normalize();
                    assert!(shown.distance(seen) < 1e-9, "{screen:?}: {shown} {seen}");
                    let wrong = pinhole.evaluate(&aside, x, y).unwrap_or_default().normalize();
                    noticed = noticed.max(wrong.distance(seen));
                }
            }
        }
        assert!(noticed > 1e-4, "{noticed:e}");
        assert!(lit.iter().chain(&dark).all(|count| *count > 300), "{lit:?} {dark:?}");
    }
}
