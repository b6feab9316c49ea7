//! Place of a vertex in an output's picture: the inverse of an output's map, for programs whose
//! vertices are projected directly to the output.
//!
//! After Kooima, Roberts & SubbaRao (2008), figure 3: the line from the viewer to the vertex meets
//! the dome in a point. The place is the position of this point in the picture of the projector (or
//! of the fisheye at the dome's centre) that lights it. No arc cosine is used: near the axis and
//! near its antipode it would lose half of the digits.

use crate::geom::Frustum;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Viewer, spherical dome and lens, all in the lens's axes and in radii of the dome.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PictureMap {
    /// Position of the viewer, from the dome's centre; inside the dome.
    pub viewer: DVec3,
    /// Position of the lens, from the dome's centre; inside the dome.
    pub position: DVec3,
    /// The lens.
    pub lens: PictureLens,
}

/// A lens whose picture fills −1…1 from left to right and from bottom to top.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum PictureLens {
    /// An equidistant fisheye.
    Fisheye {
        /// Full opening angle, radians, 0 < aperture ≤ 2π.
        aperture: f64,
        /// Half the width and height of its circle in the picture.
        circle: DVec2,
        /// Width and height of the picture in pixels. They give the size of the ring around the
        /// antipode of the axis that is left out.
        pixels: DVec2,
    },
    /// A pinhole with this opening.
    Pinhole(Frustum),
}

/// Place of a vertex in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// At this finite point; the picture reaches from −1 to 1.
    At(DVec2),
    /// Not near the picture (behind a pinhole, around the antipode of a fisheye's axis): at
    /// infinity in this direction, of any length.
    Beyond(DVec2),
}

/// Least component along a pinhole's axis, as a part of the length. Directions with less (87° off
/// the axis) are beyond its picture.
pub const LEAST_AHEAD: f64 = 0.05;

/// Width, in pixels, of the ring that is left out where a fisheye shows the antipode of its axis as
/// a whole circle.
const GIVEN_UP: f64 = 1.0;

impl PictureMap {
    /// True if all numbers are finite.
    pub fn is_finite(&self) -> bool {
        let lens = match &self.lens {
            PictureLens::Pinhole(frustum) => frustum.is_finite(),
            PictureLens::Fisheye { aperture, circle, pixels } => {
                aperture.is_finite() && circle.is_finite() && pixels.is_finite()
            }
        };
        lens && self.viewer.is_finite() && self.position.is_finite()
    }

    /// Returns the direction from the lens (lens axes, any length) to the point of the dome where
    /// the viewer sees a vertex in `direction` (lens axes, any length but 0).
    pub fn from_lens(&self, direction: DVec3) -> DVec3 {
        let unit = direction.normalize_or_zero();
        let along = self.viewer.dot(unit);
        let inside = (1.0 - self.viewer.length_squared()).max(0.0);
        self.viewer - self.position + unit * ((along * along + inside).sqrt() - along)
    }

    /// Returns the place of a vertex that the viewer sees in `direction` (lens axes, any length).
    /// The zero vector is at the picture's middle.
    pub fn place(&self, direction: DVec3) -> Place {
        let ray = self.from_lens(direction);
        match self.lens {
            PictureLens::Fisheye { aperture, circle, .. } => {
                let across = ray.truncate();
                let sine = across.length();
                // Subtraction instead of negation: −0 would make the angle π.
                let angle = sine.atan2(0.0 - ray.z);
                if angle > self.limit() {
                    // The antipode itself has no direction.
                    return Place::Beyond(across.try_normalize().unwrap_or(DVec2::X));
                }
                let part = if sine > 0.0 { angle / sine } else { 0.0 };
                Place::At(across * (2.0 * part / aperture) * circle)
            }
            PictureLens::Pinhole(frustum) => {
                // True also for the zero vector: a vertex at the viewer, who is at the lens.
                if -ray.z <= LEAST_AHEAD * ray.length() {
                    return Place::Beyond(ray.truncate().try_normalize().unwrap_or(DVec2::X));
                }
                let at = frustum.picture() * ray;
                Place::At(at.truncate() / at.z)
            }
        }
    }

    /// Returns the position (−1…1) at which the picture shows what the viewer sees in `direction`;
    /// `None` if it is outside the picture.
    pub fn shown(&self, direction: DVec3) -> Option<DVec2> {
        let Place::At(at) = self.place(direction) else { return None };
        let inside = match self.lens {
            PictureLens::Fisheye { circle, .. } => (at / circle).length() <= 1.0,
            PictureLens::Pinhole(_) => at.abs().max_element() <= 1.0,
        };
        inside.then_some(at)
    }

    /// Returns the angle from the axis, radians, beyond which directions are beyond the picture.
    /// For a fisheye it is half-way from the rim to the antipode of the axis, but at least a pixel
    /// from the antipode.
    pub fn limit(&self) -> f64 {
        match self.lens {
            PictureLens::Fisheye { aperture, circle, pixels } => {
                let radius = (circle * pixels).min_element() * 0.5;
                (0.25 * aperture + 0.5 * PI).min(PI - GIVEN_UP * 0.5 * aperture / radius.max(GIVEN_UP))
            }
            PictureLens::Pinhole(_) => (LEAST_AHEAD).acos(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Fisheye, QuadraticForm, Sphere, pose};
    use crate::testing::random::Random;
    use glam::DMat3;

    fn square(aperture: f64, pixels: f64) -> PictureLens {
        PictureLens::Fisheye { aperture, circle: DVec2::ONE, pixels: DVec2::splat(pixels) }
    }

    /// Compares with the map of the correction, which goes the other way: pixel, ray, dome, viewer.
    #[test]
    fn it_is_the_inverse_of_a_projector_s_closed_form() {
        let mut random = Random::new(21);
        let mut seen = 0;
        for _ in 0..200 {
            let mut within = |radius: f64| {
                let mut side = || random.range(-radius, radius) / 3f64.sqrt();
                DVec3::new(side(), side(), side())
            };
            let (position, viewer) = (within(0.95), within(0.9));
            let rotation = pose::rotation(random.range(-3.0, 3.0), random.range(-1.5, 1.5), random.range(-3.0, 3.0));
            let frustum = Frustum { left: -0.8, right: 1.1, bottom: -0.5, top: 0.7 };
            let sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };
            let form = QuadraticForm::new(position, rotation * frustum.rays(), &sphere, viewer, DMat3::IDENTITY);
            let to_lens = rotation.transpose();
            let map = PictureMap {
                viewer: to_lens * viewer,
                position: to_lens * position,
                lens: PictureLens::Pinhole(frustum),
            };
            for _ in 0..50 {
                let at = DVec2::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0));
                let Some(direction) = form.evaluate(at.x, at.y) else { continue };
                let place = map.place(to_lens * direction * random.range(1e-3, 1e3));
                assert!(matches!(place, Place::At(found) if found.distance(at) < 1e-9), "{place:?} for {at}");
                seen += 1;
            }
        }
        assert!(seen > 9_000, "{seen}");
    }

    #[test]
    fn a_fisheye_at_the_centre_is_the_lens_and_another_viewer_sees_past_it() {
        let mut random = Random::new(22);
        for aperture in [0.5, PI, 4.0, 2.0 * PI] {
            let lens = Fisheye { aperture };
            for _ in 0..2_000 {
                let radius = random.unit().sqrt() * 0.998;
                let (sin, cos) = random.range(-PI, PI).sin_cos();
                let at = DVec2::new(radius * cos, radius * sin);
                let on_dome = lens.direction(at.x, at.y).expect("inside the circle");
                for viewer in [DVec3::ZERO, DVec3::new(0.3, -0.5, 0.4)] {
                    let map = PictureMap { viewer, position: DVec3::ZERO, lens: square(aperture, 2048.0) };
                    let place = map.place((on_dome - viewer) * 7.0);
                    assert!(matches!(place, Place::At(found) if found.distance(at) < 1e-10), "{place:?} for {at}");
                }
            }
        }
    }

    #[test]
    fn what_lies_behind_is_beyond() {
        let hemisphere = PictureMap { viewer: DVec3::ZERO, position: DVec3::ZERO, lens: square(PI, 1024.0) };
        assert!((hemisphere.limit().to_degrees() - 135.0).abs() < 1e-12);
        assert_eq!(hemisphere.place(DVec3::NEG_Z), Place::At(DVec2::ZERO));
        assert_eq!(hemisphere.place(DVec3::ZERO), Place::At(DVec2::ZERO));
        assert_eq!(hemisphere.place(DVec3::Z), Place::Beyond(DVec2::X));
        assert!(matches!(hemisphere.place(DVec3::new(0.0, -0.1, 1.0)), Place::Beyond(at) if at.y < 0.0));
        // A fisheye of all directions leaves out a ring of one pixel.
        let whole = PictureMap { lens: square(2.0 * PI, 1024.0), ..hemisphere };
        assert!((PI - whole.limit() - PI / 512.0).abs() < 1e-12);
        let pinhole = PictureMap { lens: PictureLens::Pinhole(Frustum::symmetric(1.0, 1.0)), ..hemisphere };
        assert!(matches!(pinhole.place(DVec3::new(1.0, 0.0, 0.2)), Place::Beyond(at) if at == DVec2::X));
        assert!(matches!(pinhole.place(DVec3::new(1.0, 0.0, -0.2)), Place::At(_)));
        let at_the_eye = PictureMap { position: DVec3::NEG_Z, viewer: DVec3::NEG_Z, ..pinhole };
        assert_eq!(at_the_eye.place(DVec3::ZERO), Place::Beyond(DVec2::X), "the zero vector has no place");
    }

    /// Single-pass spherical projection as it was published in 2014: two arc cosines, in 32 bits.
    fn recipe(v: [f32; 3]) -> [f32; 2] {
        let [x, y, z] = v;
        let r = (x * x + y * y + z * z).sqrt();
        let theta = (z / r).acos();
        let azimuth = (x / (r * theta.sin())).acos();
        let azimuth = if y >= 0.0 { azimuth } else { std::f32::consts::TAU - azimuth };
        [theta * azimuth.cos(), theta * azimuth.sin()].map(|part| part / std::f32::consts::FRAC_PI_2)
    }

    /// Place of a direction as Cupola's shaders compute it, in 32 bits.
    fn ours(v: [f32; 3]) -> [f32; 2] {
        let [x, y, z] = v;
        let h = (x * x + y * y).sqrt();
        let (near, far) = (h.min(z.abs()), h.max(z.abs()));
        let t = near / far.max(1e-30);
        let sum = crate::geom::lenses::equidistant::ATAN_COEFFICIENTS
            .iter()
            .rev()
            .fold(0.0, |sum, c| sum * t * t + *c as f32);
        let octant = t + t * t * t * sum;
        let quadrant = if h > z.abs() { std::f32::consts::FRAC_PI_2 - octant } else { octant };
        let angle = if z < 0.0 { std::f32::consts::PI - quadrant } else { quadrant };
        let part = if h > 0.0 { angle / h / std::f32::consts::FRAC_PI_2 } else { 0.0 };
        [x * part, y * part]
    }

    /// Returns the greatest error, in pixels of a picture 1080 wide, and the number of results that
    /// are not finite.
    fn judged(project: fn([f32; 3]) -> [f32; 2], directions: &[[f32; 3]]) -> (f64, usize) {
        let lens = Fisheye { aperture: PI };
        let (mut worst, mut none) = (0.0f64, 0);
        for &direction in directions {
            let [x, y] = project(direction).map(f64::from);
            let [a, b, c] = direction.map(f64::from);
            match DVec2::new(x, y) {
                found if found.is_finite() => {
                    worst = worst.max(found.distance(lens.point(DVec3::new(a, b, -c))) * 540.0)
                }
                _ => none += 1,
            }
        }
        (worst, none)
    }

    #[test]
    fn arc_cosines_fail_at_the_axis_and_along_a_meridian_where_ours_does_not() {
        let mut random = Random::new(2014);
        let mut directions = Vec::new();
        for _ in 0..40_000 {
            let (sin, cos) = random.range(-PI, PI).sin_cos();
            let near = random.range(0.0, 0.1f64.to_radians());
            directions.push([near.sin() * cos, near.sin() * sin, near.cos()]);
            let (sin, cos) = random.range(0.0, 0.5 * PI).sin_cos();
            directions.push([sin, random.range(-1e-3, 1e-3) * sin, cos]);
        }
        directions.push([0.0, 0.0, 1.0]);
        let directions: Vec<[f32; 3]> = directions.into_iter().map(|v| v.map(|part| part as f32)).collect();
        let (worst, none) = judged(recipe, &directions);
        assert!(none > directions.len() / 100 && worst > 0.1, "{worst} pixels, {none} not finite");
        let (worst, none) = judged(ours, &directions);
        assert!(none == 0 && worst < 1e-3, "{worst} pixels, {none} not finite");
    }

    /// Applies the published formula in 32 bits to a whole picture of a projector, with a given arc
    /// cosine. Returns the greatest distance, in pixels, between the point that a pixel samples and
    /// the point that it should show, and the number of pixels whose results are not finite.
    fn recipe_of_a_projector(arc_cosine: fn(f32) -> f32, pixels: (u32, u32)) -> (f64, usize) {
        let frustum = Frustum::symmetric(60f64.to_radians(), 40f64.to_radians());
        let map = PictureMap {
            viewer: DVec3::ZERO,
            position: DVec3::new(0.0, 0.0, 0.6),
            lens: PictureLens::Pinhole(frustum),
        };
        let size = DVec2::new(f64::from(pixels.0), f64::from(pixels.1));
        let (mut worst, mut none) = (0.0f64, 0);
        for (row, column) in (0..pixels.1).flat_map(|row| (0..pixels.0).map(move |column| (row, column))) {
            let at = (DVec2::new(f64::from(column), f64::from(row)) + 0.5) / size * 2.0 - 1.0;
            let [x, y] = [at.x * frustum.right, at.y * frustum.top].map(|part| part as f32);
            let length = (x * x + y * y + 1.0).sqrt();
            let ray = [x / length, y / length, -1.0 / length];
            let along = 0.6 * ray[2];
            let far = (along * along - 0.36 + 1.0).sqrt() - along;
            let [x, y, z] = [far * ray[0], far * ray[1], 0.6 + far * ray[2]];
            let r = (x * x + y * y + z * z).sqrt();
            let theta = arc_cosine(-z / r);
            let azimuth = arc_cosine(x / (r * theta.sin()));
            if !(theta.is_finite() && azimuth.is_finite()) {
                none += 1;
                continue;
            }
            let azimuth = f64::from(if y < 0.0 { -azimuth } else { azimuth });
            let (sine, cosine) = f64::from(theta).sin_cos();
            let Place::At(found) = map.place(DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), -cosine)) else {
                panic!("beyond the picture")
            };
            worst = worst.max(((found - at) * 0.5 * size).length());
        }
        (worst, none)
    }

    /// The arc cosine of drivers with Mesa's compiler: a polynomial, off by up to 1.6e-4.
    fn driver_s_arc_cosine(x: f32) -> f32 {
        use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};
        let a = x.abs();
        let sum = FRAC_PI_2 + a * (FRAC_PI_4 - 1.0 + a * (0.081_324_63 - a * 0.023_633_18));
        FRAC_PI_2 - x.signum() * (FRAC_PI_2 - (1.0 - a).sqrt() * sum)
    }

    /// The published formula fails over a whole picture, by its own rounding and by the driver's
    /// arc cosine.
    #[test]
    fn arc_cosines_fail_over_the_picture_of_a_projector() {
        let (worst, none) = recipe_of_a_projector(driver_s_arc_cosine, (1920, 1080));
        assert!((8.0..11.0).contains(&worst) && (4_000..7_000).contains(&none), "{worst} pixels, {none} not finite");
        let (worst, _) = recipe_of_a_projector(f32::acos, (1920, 1080));
        assert!((0.2..1.0).contains(&worst), "with a good arc cosine {worst} pixels");
    }

    /// Error of Cupola's formula over the same picture, in 32 bits.
    #[test]
    fn ours_does_not_fail_there() {
        let frustum = Frustum::symmetric(60f64.to_radians(), 40f64.to_radians());
        let (width, height) = (1920u32, 1080u32);
        let scale = [1.0 / frustum.right, 1.0 / frustum.top].map(|part| part as f32);
        let mut worst = 0.0f64;
        for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
            let size = DVec2::new(f64::from(width), f64::from(height));
            let at = (DVec2::new(f64::from(column), f64::from(row)) + 0.5) / size * 2.0 - 1.0;
            let ray = DVec3::new(at.x * frustum.right, at.y * frustum.top, -1.0).normalize();
            let along = 0.6 * ray.z;
            let seen = DVec3::new(0.0, 0.0, 0.6) + ray * ((along * along + 0.64).sqrt() - along);
            // As `cupola_place` in GLSL: the viewer at the centre, the lens at 0.6.
            let [x, y, z] = seen.normalize().to_array().map(|part| part as f32);
            let (x, y, z) = (x, y, z - 0.6);
            let found = DVec2::new(f64::from(x / -z * scale[0]), f64::from(y / -z * scale[1]));
            let off = ((found - at) * 0.5 * size).length();
            assert!(off.is_finite());
            worst = worst.max(off);
        }
        assert!(worst < 1e-3, "{worst} pixels");
    }
}
