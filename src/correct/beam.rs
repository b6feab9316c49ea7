//! The rays of a projector inside the sphere, from which its forms follow with fewer operations.

use super::plan::ProjectorSource;
use super::rounding::{self, Sum};
use crate::geom::QuadraticForm;
use crate::geom::quadratic::{linear_at, quadratic_at};
use glam::DVec3;

/// The rays `o + t·d` of a projector inside the sphere. Each
/// form is `offset·a + linear·(√D − b)`, with `a = d·d`, `b = o·d`, `D = b² + depth·a`. Since
/// `(√D − b)·(√D + b) = depth·a`, the same direction is `offset·(√D + b) + linear·depth`, and, b being linear in
/// the pixel, `offset·√D` plus a linear function: one root is all that is not linear.
///
/// Near the sphere `√D + b` cancels; `offset/t + linear`, with `1/t = a/(√D − b)`, does not. Farther out `D` itself
/// cancels, and only the forms' own coefficients, which are rounded after the cancellation, are exact.
pub(super) struct Beam {
    /// a = d·d over `[x², y², xy, x, y, 1]`.
    pub squared: [f64; 6],
    /// b = o·d over `[x, y, 1]`.
    pub along: [f64; 3],
    /// R² − o·o, > 0.
    depth: f64,
}

/// How the forms of a projector are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// `offset·√D + linear'`: the fewest operations.
    Root,
    /// `offset/t + linear`.
    Distance,
}

/// Inside the sphere, as the forms take it: up to this part of its radius.
const INSIDE: f64 = 0.95;

impl Beam {
    /// `None` for a projector outside the sphere or near it.
    pub fn of(source: &ProjectorSource) -> Option<Self> {
        let o = source.position;
        let l = source.dome_direction.l;
        // The columns of d: `l` has a row for each component.
        let columns = [0, 1, 2].map(|k| DVec3::new(l[0][k], l[1][k], l[2][k]));
        let [x, y, one] = columns;
        let squared = [x.dot(x), y.dot(y), 2.0 * x.dot(y), 2.0 * x.dot(one), 2.0 * y.dot(one), one.dot(one)];
        let along = columns.map(|column| o.dot(column));
        // D = b² + depth·a
        let depth = (source.dome_direction.d[5] - along[2] * along[2]) / squared[5];
        let radius_squared = depth + o.length_squared();
        let inside = o.length_squared() <= INSIDE * INSIDE * radius_squared;
        let beam = Self { squared, along, depth };
        let alike = differs_by(&beam.discriminant(), &source.dome_direction.d) <= ALIKE;
        (inside && depth > 0.0 && alike).then_some(beam)
    }

    /// The cheapest way that rounding leaves exact enough for pictures of `size`; `None` where the forms themselves are
    /// better.
    pub fn way(&self, source: &ProjectorSource, size: (u32, u32)) -> Option<Way> {
        let form = &source.direction;
        let offset = self.offset(form)?;
        let good = |way: Way| {
            rounding::excess(form, source.cap.as_ref(), size, |x, y| Some(self.sum(way, form, offset, x, y))) <= 1.0
        };
        [Way::Root, Way::Distance].into_iter().find(|way| good(*way))
    }

    /// What a form adds up at a pixel.
    fn sum(&self, way: Way, form: &QuadraticForm, offset: DVec3, x: f64, y: f64) -> Sum {
        let (root, from_root) = rounding::root(&self.discriminant(), x, y);
        let (linear, factor, spread) = match way {
            Way::Root => (self.freed(&form.l, offset), root, root + from_root),
            Way::Distance => {
                let a = quadratic_at(&self.squared, x, y);
                let below = root - linear_at(&self.along, x, y);
                let terms = (from_root + rounding::linear_terms(&self.along, x, y)) / below;
                let reach = a / below;
                (form.l, reach, reach * (rounding::quadratic_terms(&self.squared, x, y) / a + terms))
            }
        };
        let value = DVec3::from_array(linear.map(|row| linear_at(&row, x, y))) + offset * factor;
        let terms = DVec3::from_array(linear.map(|row| rounding::linear_terms(&row, x, y))) + offset.abs() * spread;
        Sum { value, terms }
    }

    /// D over `[x², y², xy, x, y, 1]`.
    pub fn discriminant(&self) -> [f64; 6] {
        let b = times(&self.along, &self.along);
        std::array::from_fn(|k| b[k] + self.depth * self.squared[k])
    }

    /// A form's linear part once it is freed of a and b.
    pub fn freed(&self, linear: &[[f64; 3]; 3], offset: DVec3) -> [[f64; 3]; 3] {
        [0, 1, 2].map(|i| std::array::from_fn(|k| linear[i][k] * self.depth + offset[i] * self.along[k]))
    }

    /// What multiplies a in a form of this projector; `None` where it is none.
    pub fn offset(&self, form: &QuadraticForm) -> Option<DVec3> {
        let mut offset = DVec3::ZERO;
        for i in 0..3 {
            let linear = times(&form.l[i], &self.along);
            let rest: [f64; 6] = std::array::from_fn(|k| form.q[i][k] + linear[k]);
            offset[i] = rest[5] / self.squared[5];
            let expected: [f64; 6] = std::array::from_fn(|k| offset[i] * self.squared[k] - linear[k]);
            if differs_by(&expected, &form.q[i]) > ALIKE {
                return None;
            }
        }
        (differs_by(&self.discriminant(), &form.d) <= ALIKE).then_some(offset)
    }
}

/// How closely two quadratic polynomials must agree, as a part of their greatest coefficient.
const ALIKE: f64 = 1e-9;

/// The greatest difference of two polynomials' coefficients, as a part of the greatest coefficient.
fn differs_by(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    let size = a.iter().chain(b).fold(f64::MIN_POSITIVE, |size, c| size.max(c.abs()));
    a.iter().zip(b).fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs())) / size
}

/// The product of two linear polynomials over `[x, y, 1]`.
fn times(u: &[f64; 3], v: &[f64; 3]) -> [f64; 6] {
    [
        u[0] * v[0],
        u[1] * v[1],
        u[0] * v[1] + u[1] * v[0],
        u[0] * v[2] + u[2] * v[0],
        u[1] * v[2] + u[2] * v[1],
        u[2] * v[2],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::plan::{Source, build};
    use crate::rig;
    use crate::views::Request;
    use std::path::Path;

    /// How the only projector of a rig is computed.
    fn source(viewer: [f64; 3], projector: [f64; 3], fov: f64) -> Source {
        let text = format!(
            "[dome]\nradius = 1.0\ncoverage = 360\n[viewer]\nposition = {viewer:?}\n[[output]]\nkind = \"projector\"\n\
             position = {projector:?}\npitch = 30\nfov = [{fov}, {fov}]\n"
        );
        let rig = rig::parse(&text, "beam.toml", Path::new("")).expect("valid");
        let size = (256, 256);
        let request =
            Request { output_sizes: vec![size], window: size, panel: false, primary: false, max_atlas: 16384 };
        build(&rig, &request).expect("can be planned").passes.remove(0).source
    }

    fn way(source: &Source) -> Option<Way> {
        let Source::Projector(projector) = source else { return None };
        Beam::of(projector)?.way(projector, (256, 256))
    }

    #[test]
    fn the_cheapest_way_is_taken_that_rounding_allows() {
        let near = source([0.0; 3], [0.0, 0.0, 0.3], 60.0);
        assert_eq!(way(&near), Some(Way::Root));
        let far = source([0.0; 3], [0.0, 0.0, 0.9], 60.0);
        assert_ne!(way(&far), Some(Way::Root));
        // Nearer to the wall than the beam goes, and outside: the forms themselves.
        for distance in [0.97, 2.0] {
            let outside = source([0.0; 3], [0.0, -0.5 * distance, 0.8 * distance], 20.0);
            assert!(matches!(outside, Source::Projector(_)) && way(&outside).is_none(), "{distance}");
        }
    }

    #[test]
    fn what_f32_cannot_hold_is_a_table() {
        // Light that passes a viewer near the screen: what is seen is a small difference of places.
        let towards = glam::DMat3::from_rotation_x(30f64.to_radians()) * DVec3::NEG_Z;
        let viewer = towards * 0.98;
        assert!(matches!(source(viewer.to_array(), [0.0; 3], 10.0), Source::Table(_)));
        assert!(matches!(source([0.0; 3], [0.0; 3], 10.0), Source::Projector(_)), "a viewer in the middle");
    }
}
