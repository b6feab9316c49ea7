//! Exact closed form of the point at which a pinhole's ray meets a sphere, another quadric or a
//! plane, as a perspective view sees it.

use super::{Quadric, Sphere};
use glam::{DAffine3, DMat3, DVec3};

/// Coefficients of `s(x, y) = Q(x, y) + L(x, y)·√D(x, y)` over the monomials in the order `[x², y²,
/// xy, x, y, 1]` (Q and D) and `[x, y, 1]` (L). `s` is an affine function of the point that the ray
/// meets, homogeneous, with positive scale. The line of the ray meets the surface iff `D ≥ 0`.
///
/// Derivation: the dot product is the surface's [`Quadric::product`]. The line `o + t·d` meets the
/// surface at `t = (−b ± √D)/a` with `a = d·d`, `b = o·d`, `D = level·a − |o × d|²`. In `|o × d|²`
/// the weight of each square is the product of two weights. Scaled by `a > 0`, the far hit of a
/// sphere is `d × (o × d) + d·√D`; other quadrics have the same form with weights. `d` is linear in
/// the pixel, so the first term is quadratic. All cancellations between large numbers happen here,
/// in f64, before the coefficients are rounded.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct QuadraticForm {
    /// The quadratic part, a row per component of `s`.
    pub q: [[f64; 6]; 3],
    /// The linear factor of the root, a row per component of `s`.
    pub l: [[f64; 3]; 3],
    /// The discriminant.
    pub d: [f64; 6],
    /// Value of the affine function at the pinhole: `Q = offset·a − L·b`. It is 0 for a plane,
    /// where nothing is quadratic.
    pub offset: DVec3,
}

/// Three linear functions of the pixel, as three vectors: `columns[0]·x + columns[1]·y +
/// columns[2]`.
#[derive(Clone, Copy)]
struct LinearVector([DVec3; 3]);

impl LinearVector {
    fn of(rays: DMat3) -> Self {
        Self([rays.x_axis, rays.y_axis, rays.z_axis])
    }

    /// Coefficients of component `index` over `[x, y, 1]`.
    fn row(&self, index: usize) -> [f64; 3] {
        [self.0[0][index], self.0[1][index], self.0[2][index]]
    }

    /// Coefficients of `Σ weights·u²` over `[x², y², xy, x, y, 1]`.
    fn square(&self, weights: DVec3) -> [f64; 6] {
        let dot = |i: usize, j: usize| (weights * self.0[i]).dot(self.0[j]);
        [dot(0, 0), dot(1, 1), 2.0 * dot(0, 1), 2.0 * dot(0, 2), 2.0 * dot(1, 2), dot(2, 2)]
    }
}

/// Coefficients of the product of two linear functions over `[x², y², xy, x, y, 1]`.
pub(crate) fn product(u: [f64; 3], v: [f64; 3]) -> [f64; 6] {
    [
        u[0] * v[0],
        u[1] * v[1],
        u[0] * v[1] + u[1] * v[0],
        u[0] * v[2] + u[2] * v[0],
        u[1] * v[2] + u[2] * v[1],
        u[2] * v[2],
    ]
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

/// Quadratic polynomial `d·d` of a pinhole's rays, with the surface's product.
pub(crate) fn squared(rays: DMat3, quadric: &Quadric) -> [f64; 6] {
    LinearVector::of(rays).square(quadric.weights)
}

impl QuadraticForm {
    /// Returns the form for the point at which a ray leaves the inside of `quadric` (of a sphere
    /// the **far** hit). The pinhole is at `origin`, and its pixel `(x, y)` sends the ray `rays·(x,
    /// y, 1)`, both in the surface's axes. `map` converts the point to an eye's axes, or to
    /// homogeneous picture coordinates, such as [`super::Frustum::picture`] after a lens's axes.
    ///
    /// The form does not distinguish rays that meet the surface from rays whose backward extension
    /// meets it, so [`super::PinholeRays::looks_at_it`] must hold. In a double cone half of the
    /// rays from inside have a negative scale.
    pub fn on(origin: DVec3, rays: DMat3, quadric: &Quadric, map: DAffine3) -> Self {
        let direction = LinearVector::of(rays);
        let moment = LinearVector(direction.0.map(|column| origin.cross(column)));
        let w = quadric.weights;
        // d × (o × d), each product of two components with its weight.
        let foot = [(0, 1, 2), (1, 2, 0), (2, 0, 1)].map(|(_, j, k)| {
            let first = product(direction.row(j), moment.row(k)).map(|c| c * w[j]);
            added(first, -w[k], product(direction.row(k), moment.row(j)))
        });
        let scale = direction.square(w);
        let in_pairs = DVec3::new(w.y * w.z, w.z * w.x, w.x * w.y);
        let d = added(scale.map(|c| c * quadric.level), -1.0, moment.square(in_pairs));
        let untouched = Self { q: foot, l: [0, 1, 2].map(|i| direction.row(i)), d, offset: origin };
        let mut form = untouched.transformed(map.matrix3);
        form.q = [0, 1, 2].map(|i| added(form.q[i], map.translation[i], scale));
        form.offset += map.translation;
        form
    }

    /// Returns the form for the plane z = 0, which is lit from either side. It is linear in the
    /// pixel, and `D = 1`.
    pub fn on_plane(origin: DVec3, rays: DMat3, map: DAffine3) -> Self {
        // Multiplied by `towards`, the ray's component towards the plane, the point is o·towards +
        // d·|o.z|.
        let at_origin = map.transform_point3(origin);
        let column = |ray: DVec3| at_origin * (-origin.z.signum() * ray.z) + map.matrix3 * ray * origin.z.abs();
        let linear = LinearVector([column(rays.x_axis), column(rays.y_axis), column(rays.z_axis)]);
        let d = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        Self { q: [[0.0; 6]; 3], l: [0, 1, 2].map(|i| linear.row(i)), d, offset: DVec3::ZERO }
    }

    /// [`Self::on`] for a sphere at any position, seen from `eye`. `target` rotates world axes to
    /// the axes of the result.
    pub fn new(origin: DVec3, rays: DMat3, sphere: &Sphere, eye: DVec3, target: DMat3) -> Self {
        let map = DAffine3 { matrix3: target, translation: target * (sphere.center - eye) };
        Self::on(origin - sphere.center, rays, &Quadric::from(sphere), map)
    }

    /// Returns the form after another linear map of its value: `matrix · s`.
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
        Self { q: rows.map(|r| r.0), l: rows.map(|r| r.1), d: self.d, offset: matrix * self.offset }
    }

    /// Value of D at a pixel: ≥ 0 where the ray's line meets the surface.
    pub fn discriminant(&self, x: f64, y: f64) -> f64 {
        quadratic_at(&self.d, x, y)
    }

    /// The homogeneous value at a pixel, not normalised; `None` where the ray misses (D < 0).
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Frustum, Pose};
    use crate::testing::random::Random;

    /// A pinhole at `distance` from the centre, aimed at a random point near it. The sphere fills
    /// its picture.
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
        // Negative control: an eye at another position gives another result.
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
    }
}
