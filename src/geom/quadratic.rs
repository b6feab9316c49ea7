//! The exact closed form of a pinhole ray that meets a sphere and is seen by a perspective view.

use super::Sphere;
use glam::{DMat3, DVec3};

/// `s(x, y) = Q(x, y) + L(x, y)·√D(x, y)`: 33 coefficients over the monomials in the order
/// `[x², y², xy, x, y, 1]` (Q and D) and `[x, y, 1]` (L). `s` is a homogeneous direction with
/// positive scale; the ray meets the sphere iff `D ≥ 0`.
///
/// Derivation: the line `o + t·d` (origin relative to the centre) meets the sphere of radius R at
/// `t = (−b ± √D)/a` with `a = d·d`, `b = o·d`, `D = R²·a − |o × d|²`. Seen from an eye V and scaled by
/// `a > 0`, the far hit is `d × (o × d) − V·a + d·√D`; with `d` linear in the pixel, the first two terms are
/// quadratic. All cancellations between large numbers happen here, in f64, before the coefficients are rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraticForm {
    /// The quadratic part, a row per component of `s`.
    pub q: [[f64; 6]; 3],
    /// The linear factor of the root, a row per component of `s`.
    pub l: [[f64; 3]; 3],
    /// The discriminant.
    pub d: [f64; 6],
}

/// Three linear functions of the pixel, as three vectors: `columns[0]·x + columns[1]·y + columns[2]`.
#[derive(Clone, Copy)]
struct LinearVector([DVec3; 3]);

impl LinearVector {
    /// The row of component `index` over `[x, y, 1]`.
    fn row(&self, index: usize) -> [f64; 3] {
        [self.0[0][index], self.0[1][index], self.0[2][index]]
    }
}

/// The product of two linear functions over `[x², y², xy, x, y, 1]`.
fn product(u: [f64; 3], v: [f64; 3]) -> [f64; 6] {
    [
        u[0] * v[0],
        u[1] * v[1],
        u[0] * v[1] + u[1] * v[0],
        u[0] * v[2] + u[2] * v[0],
        u[1] * v[2] + u[2] * v[1],
        u[2] * v[2],
    ]
}

/// `|u|²` over `[x², y², xy, x, y, 1]`.
fn length_squared(u: &LinearVector) -> [f64; 6] {
    let [a, b, c] = u.0;
    [a.dot(a), b.dot(b), 2.0 * a.dot(b), 2.0 * a.dot(c), 2.0 * b.dot(c), c.dot(c)]
}

/// `u + factor·v`.
fn added<const N: usize>(u: [f64; N], factor: f64, v: [f64; N]) -> [f64; N] {
    std::array::from_fn(|i| u[i] + factor * v[i])
}

/// The value of a quadratic polynomial at a pixel, by Horner's scheme.
pub(crate) fn quadratic_at(c: &[f64; 6], x: f64, y: f64) -> f64 {
    (c[0] * x + (c[2] * y + c[3])) * x + ((c[1] * y + c[4]) * y + c[5])
}

/// The value of a linear polynomial at a pixel.
pub(crate) fn linear_at(c: &[f64; 3], x: f64, y: f64) -> f64 {
    c[0] * x + (c[1] * y + c[2])
}

/// The quadratic part of the hit relative to the centre, `d × (o × d)`, with `d` and `d·d`.
fn foot(origin: DVec3, rays: DMat3) -> ([[f64; 6]; 3], LinearVector, LinearVector) {
    let direction = LinearVector([rays.x_axis, rays.y_axis, rays.z_axis]);
    let moment = LinearVector(direction.0.map(|column| origin.cross(column)));
    let component = |i: usize, j: usize| {
        added(product(direction.row(i), moment.row(j)), -1.0, product(direction.row(j), moment.row(i)))
    };
    ([component(1, 2), component(2, 0), component(0, 1)], direction, moment)
}

impl QuadraticForm {
    /// The form of a pinhole at `origin` whose pixel `(x, y)` sends the ray `rays·(x, y, 1)`, both in
    /// world axes, for the **far** hit on `sphere`, seen from `eye` and turned by `target`
    /// (world axes → the axes wanted; may also be homogeneous picture coordinates, such as
    /// [`super::Frustum::picture`] times a rotation).
    ///
    /// From outside the sphere the form does not tell rays that meet it from rays whose backward
    /// extension meets it: [`sphere_is_ahead`] must hold.
    pub fn new(origin: DVec3, rays: DMat3, sphere: &Sphere, eye: DVec3, target: DMat3) -> Self {
        let (foot, direction, moment) = foot(origin - sphere.center, rays);
        let scale = length_squared(&direction);
        let eye = eye - sphere.center;
        let q = [0, 1, 2].map(|i| added(foot[i], -eye[i], scale));
        let l = [0, 1, 2].map(|i| direction.row(i));
        let radius_squared = sphere.radius * sphere.radius;
        let d = added(scale.map(|c| c * radius_squared), -1.0, length_squared(&moment));
        Self { q, l, d }.transformed(target)
    }

    /// The form after another linear map of its value: `matrix · s`.
    pub fn transformed(&self, matrix: DMat3) -> Self {
        if matrix == DMat3::IDENTITY {
            return *self;
        }
        let row = |i: usize| [matrix.x_axis[i], matrix.y_axis[i], matrix.z_axis[i]];
        let mix = |i: usize| {
            let m = row(i);
            (
                std::array::from_fn(|k| m[0] * self.q[0][k] + m[1] * self.q[1][k] + m[2] * self.q[2][k]),
                std::array::from_fn(|k| m[0] * self.l[0][k] + m[1] * self.l[1][k] + m[2] * self.l[2][k]),
            )
        };
        let rows: [([f64; 6], [f64; 3]); 3] = [mix(0), mix(1), mix(2)];
        Self { q: rows.map(|r| r.0), l: rows.map(|r| r.1), d: self.d }
    }

    /// D at a pixel: ≥ 0 where the ray's line meets the sphere.
    pub fn discriminant(&self, x: f64, y: f64) -> f64 {
        quadratic_at(&self.d, x, y)
    }

    /// The homogeneous direction at a pixel, positively scaled, not normalised; `None` where the ray misses (D < 0).
    pub fn evaluate(&self, x: f64, y: f64) -> Option<DVec3> {
        let discriminant = self.discriminant(x, y);
        if discriminant.is_nan() || discriminant < 0.0 {
            return None;
        }
        let root = discriminant.sqrt();
        let component = |i: usize| quadratic_at(&self.q[i], x, y) + linear_at(&self.l[i], x, y) * root;
        Some(DVec3::new(component(0), component(1), component(2)))
    }
}

/// Whether no pixel (x and y in −1…1) of a pinhole has the sphere behind it: the condition under which
/// [`QuadraticForm`] has no ghosts. True for every pinhole inside the sphere or on it, and for one outside
/// whose whole picture looks less than 90° away from the centre.
pub fn sphere_is_ahead(origin: DVec3, rays: DMat3, sphere: &Sphere) -> bool {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let ahead = |(x, y)| (rays * DVec3::new(x, y, 1.0)).dot(origin - sphere.center) < 0.0;
    // The product is linear in the pixel: the corners speak for all.
    sphere.contains(origin) || corners.into_iter().all(ahead)
}

/// Coefficients `(q, l)` of a row whose value `Q + L·√D`, with the D of the same pinhole and sphere,
/// is ≥ 0 exactly where the far hit lies on the cap around the unit vector `pole` (world axes) with
/// the whole opening angle `coverage` (radians, 0 < coverage ≤ 2π): `(hit − centre)·pole ≥ R·cos(coverage/2)`,
/// times `d·d > 0`.
pub fn cap_row(origin: DVec3, rays: DMat3, sphere: &Sphere, pole: DVec3, coverage: f64) -> ([f64; 6], [f64; 3]) {
    let (foot, direction, _) = foot(origin - sphere.center, rays);
    let limit = sphere.radius * (0.5 * coverage).cos();
    let scale = length_squared(&direction);
    let q = std::array::from_fn(|k| pole.x * foot[0][k] + pole.y * foot[1][k] + pole.z * foot[2][k] - limit * scale[k]);
    (q, direction.0.map(|column| column.dot(pole)))
}

/// The value of a row of [`cap_row`] at a pixel with the discriminant `d` of its form; NaN where the ray misses.
pub fn row_at(row: &([f64; 6], [f64; 3]), d: f64, x: f64, y: f64) -> f64 {
    quadratic_at(&row.0, x, y) + linear_at(&row.1, x, y) * d.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::random::Random;
    use crate::geom::{Frustum, Pose};

    /// A pinhole somewhere, aimed at a random point near the centre, with an opening that the sphere fills.
    fn pinhole(random: &mut Random, distance: f64) -> (DVec3, DMat3) {
        let origin = random.direction() * distance;
        let aim = random.direction() * 0.3 - origin;
        let forward = aim.normalize();
        let right = forward.cross(random.direction()).normalize();
        let rotation = DMat3::from_cols(right, right.cross(forward), -forward);
        let half = if distance < 1.0 { 0.6 } else { 0.8 / distance };
        let frustum = Frustum { left: -half, right: half, bottom: -half, top: half }.shifted(0.07, -0.13);
        (origin, rotation * frustum.rays())
    }

    #[test]
    fn agrees_with_traced_rays_from_anywhere() {
        let mut random = Random::new(4);
        let sphere = Sphere { center: DVec3::new(0.3, -0.2, 0.1), radius: 1.0 };
        for distance in [0.0, 0.3, 0.9, 0.99, 2.0, 10.0, 1e3, 1e6] {
            let mut worst = 0.0f64;
            for _ in 0..300 {
                let (origin, rays) = pinhole(&mut random, distance);
                let (origin, eye) = (origin + sphere.center, sphere.center + random.direction() * 0.6);
                let target = random.rotation();
                let form = QuadraticForm::new(origin, rays, &sphere, eye, target);
                for _ in 0..20 {
                    let (x, y) = (random.range(-1.0, 1.0), random.range(-1.0, 1.0));
                    let traced = sphere.far_hit(origin, rays * DVec3::new(x, y, 1.0)).map(|hit| target * (hit - eye));
                    if form.discriminant(x, y) < 1e-3 * form.d[5] {
                        continue;
                    }
                    let (Some(closed), Some(traced)) = (form.evaluate(x, y), traced) else {
                        panic!("one of them misses at {distance}");
                    };
                    worst = worst.max(closed.normalize().cross(traced.normalize()).length());
                    assert!(closed.dot(traced) > 0.0);
                }
            }
            assert!(worst < 1e-14 * (1.0 + distance) * 40.0, "{distance}: {worst:e}");
        }
    }

    #[test]
    fn folds_views_in() {
        let pose = Pose::new(DVec3::new(0.2, 0.1, 0.4), 0.3, 0.2, 0.1);
        let rays = pose.rotation * Frustum::symmetric(1.0, 0.7).rays();
        let sphere = Sphere { center: DVec3::ZERO, radius: 2.0 };
        let (eye, view) = (DVec3::new(0.0, -0.5, 0.2), Pose::new(DVec3::ZERO, 1.0, 0.5, 0.0).rotation.transpose());
        let picture = Frustum::symmetric(1.5, 1.5).picture();
        let plain = QuadraticForm::new(pose.position, rays, &sphere, eye, DMat3::IDENTITY);
        let direct = QuadraticForm::new(pose.position, rays, &sphere, eye, picture * view);
        let (a, b) = (plain.transformed(view).transformed(picture).evaluate(0.3, -0.9), direct.evaluate(0.3, -0.9));
        let (Some(a), Some(b)) = (a, b) else { panic!("from inside every ray hits") };
        assert!(a.distance(b) < 1e-13);
        let expected = picture * view * plain.evaluate(0.3, -0.9).unwrap_or_default();
        assert!(a.distance(expected) < 1e-13);
        // Negative control: an eye elsewhere is not the same.
        let other = QuadraticForm::new(pose.position, rays, &sphere, DVec3::ZERO, picture * view);
        assert!(other.evaluate(0.3, -0.9).unwrap_or_default().distance(b) > 1e-2);
    }

    #[test]
    fn the_discriminant_tells_misses() {
        let sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };
        let rays = Frustum { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 }.rays();
        let form = QuadraticForm::new(DVec3::new(0.0, 0.0, 2.0), rays, &sphere, DVec3::ZERO, DMat3::IDENTITY);
        let silhouette = (1.0f64 / 3.0).sqrt();
        assert!(form.evaluate(silhouette - 1e-9, 0.0).is_some() && form.evaluate(silhouette + 1e-9, 0.0).is_none());
        assert!(form.evaluate(f64::NAN, 0.0).is_none());
        assert!(sphere_is_ahead(DVec3::new(0.0, 0.0, 2.0), rays, &sphere));
        assert!(!sphere_is_ahead(DVec3::new(0.0, 0.0, -2.0), rays, &sphere), "aimed away");
        assert!(sphere_is_ahead(DVec3::new(0.0, 0.0, -0.9), rays, &sphere), "from inside there is no behind");
    }

    #[test]
    fn the_cap_is_where_the_hit_is_near_the_pole() {
        let mut random = Random::new(5);
        let sphere = Sphere { center: DVec3::new(1.0, 2.0, 3.0), radius: 5.0 };
        let mut seen = [0, 0];
        for _ in 0..5_000 {
            let origin = sphere.center + random.direction() * random.range(0.0, 4.5);
            let (_, rays) = pinhole(&mut random, 0.5);
            let (pole, coverage) = (random.direction(), random.range(0.1, std::f64::consts::TAU));
            let row = cap_row(origin, rays, &sphere, pole, coverage);
            let form = QuadraticForm::new(origin, rays, &sphere, sphere.center, DMat3::IDENTITY);
            let (x, y) = (random.range(-1.0, 1.0), random.range(-1.0, 1.0));
            let Some(hit) = sphere.far_hit(origin, rays * DVec3::new(x, y, 1.0)) else { panic!("inside") };
            let angle = (hit - sphere.center).angle_between(pole);
            if (angle - 0.5 * coverage).abs() > 1e-6 {
                let inside = row_at(&row, form.discriminant(x, y), x, y) >= 0.0;
                assert_eq!(inside, angle < 0.5 * coverage);
                seen[usize::from(inside)] += 1;
            }
        }
        assert!(seen[0] > 500 && seen[1] > 500, "both cases occur: {seen:?}");
    }
}
