//! The rays of a projector inside its screen, from which its forms follow with fewer operations.

use crate::correct::passes::source::{EvaluationMethod, ProjectorSource};
use crate::correct::sources::rounding::{self, Sum};
use crate::geom::quadratic::{linear_at, product, quadratic_at, squared};
use crate::geom::screen::ClosedSurface;
use crate::geom::{PinholeRays, QuadraticForm, Quadric};
use glam::DVec3;

/// The rays `o + t·d` of a projector inside a quadric. Each form is `offset·a + linear·(√D − b)`,
/// with `a = d·d`, `b = o·d`, `D = b² + depth·a`. Since `(√D − b)·(√D + b) = depth·a`, the same
/// direction is `offset·(√D + b) + linear·depth`, and, b being linear in the pixel, `offset·√D`
/// plus a linear function: one root is the only part that is not linear.
///
/// Near the surface `√D + b` cancels; `offset/t + linear`, with `1/t = a/(√D − b)`, does not,
/// unless a vanishes, as it does in a double cone. Farther out `D` itself cancels, and only the
/// forms' own coefficients, which are rounded after the cancellation, are exact.
pub(in crate::correct) struct RayForm {
    /// a = d·d over `[x², y², xy, x, y, 1]`.
    pub squared: [f64; 6],
    /// b = o·d over `[x, y, 1]`.
    pub along: [f64; 3],
    /// level − o·o, > 0.
    depth: f64,
}

/// The ray form is used inside the surface, up to this part of its radius.
const INSIDE: f64 = 0.95;

/// Returns the cheapest evaluation that rounding leaves exact enough for pictures of `size`, if
/// there is one.
fn evaluation(source: &ProjectorSource, size: (u32, u32)) -> Option<EvaluationMethod> {
    let ray_form = RayForm::of(&source.pinhole);
    let methods: &[EvaluationMethod] = match &source.pinhole.surface {
        ClosedSurface::Plane => &[EvaluationMethod::Linear],
        ClosedSurface::Quadric(quadric) => match (&ray_form, quadric.is_convex()) {
            (Some(_), true) => &[EvaluationMethod::Root, EvaluationMethod::Distance, EvaluationMethod::Forms],
            (Some(_), false) => &[EvaluationMethod::Root],
            (None, true) => &[EvaluationMethod::Forms],
            (None, false) => &[],
        },
    };
    methods.iter().copied().find(|&evaluation| {
        rounding::is_exact(source, size, |form, x, y| match (&ray_form, evaluation) {
            (Some(ray_form), EvaluationMethod::Root | EvaluationMethod::Distance) => {
                Some(ray_form.sum(evaluation, form, x, y))
            }
            _ => rounding::of_form(form, x, y),
        })
    })
}

impl ProjectorSource {
    /// Returns the source with the cheapest evaluation that is exact enough for pictures of `size`;
    /// `None` if there is none.
    pub fn settled(mut self, size: (u32, u32)) -> Option<Self> {
        self.evaluation = evaluation(&self, size)?;
        Some(self)
    }
}

impl RayForm {
    /// Returns `None` for a projector outside its quadric or near it, and before a plane.
    pub fn of(pinhole: &PinholeRays) -> Option<Self> {
        let ClosedSurface::Quadric(quadric) = &pinhole.surface else { return None };
        pinhole.is_inside(INSIDE).then(|| Self::new(pinhole, quadric))
    }

    fn new(pinhole: &PinholeRays, quadric: &Quadric) -> Self {
        let rays = pinhole.rays;
        let along = [rays.x_axis, rays.y_axis, rays.z_axis].map(|ray| quadric.product(pinhole.origin, ray));
        Self { squared: squared(rays, quadric), along, depth: quadric.depth(pinhole.origin) }
    }

    /// Returns the sum of a form at a pixel.
    fn sum(&self, evaluation: EvaluationMethod, form: &QuadraticForm, x: f64, y: f64) -> Sum {
        let offset = form.offset;
        let (root, from_root) = rounding::root(&self.discriminant(), x, y);
        let (linear, factor, spread) = if evaluation == EvaluationMethod::Distance {
            let a = quadratic_at(&self.squared, x, y);
            let below = root - linear_at(&self.along, x, y);
            let terms = (from_root + rounding::linear_terms(&self.along, x, y)) / below;
            let reach = a / below;
            (form.l, reach, reach * (rounding::quadratic_terms(&self.squared, x, y) / a + terms))
        } else {
            (self.freed(form), root, root + from_root)
        };
        let value = DVec3::from_array(linear.map(|row| linear_at(&row, x, y))) + offset * factor;
        let terms = DVec3::from_array(linear.map(|row| rounding::linear_terms(&row, x, y))) + offset.abs() * spread;
        Sum { value, terms }
    }

    /// Returns D over `[x², y², xy, x, y, 1]`.
    pub fn discriminant(&self) -> [f64; 6] {
        let b = product(self.along, self.along);
        std::array::from_fn(|k| b[k] + self.depth * self.squared[k])
    }

    /// Returns a form's linear part after a and b are eliminated.
    pub fn freed(&self, form: &QuadraticForm) -> [[f64; 3]; 3] {
        [0, 1, 2].map(|i| std::array::from_fn(|k| form.l[i][k] * self.depth + form.offset[i] * self.along[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::passes::source::Source;
    use crate::correct::plan::builder::build;
    use crate::rig;
    use crate::views::Request;
    use std::path::Path;

    /// Returns the source of the only projector of a rig.
    fn source(viewer: [f64; 3], projector: [f64; 3], fov: f64) -> Source {
        let text = format!(
            "[dome]\nradius = 1.0\ncoverage = 360\n[viewer]\nposition = {viewer:?}\n[[output]]\nkind = \"projector\"\n\
             position = {projector:?}\npitch = 30\nfov = [{fov}, {fov}]\n"
        );
        let rig = rig::parse(&text, "ray_form.toml", Path::new("")).expect("valid");
        let size = (256, 256);
        let request =
            Request { output_sizes: vec![size], window: size, panel: false, primary: false, max_atlas: 16384 };
        build(&rig, &request).expect("can be planned").passes.remove(0).source
    }

    fn evaluation_of(source: &Source) -> Option<EvaluationMethod> {
        let Source::Projector(projector) = source else { return None };
        Some(projector.evaluation)
    }

    #[test]
    fn the_cheapest_way_is_taken_that_rounding_allows() {
        let near = source([0.0; 3], [0.0, 0.0, 0.3], 60.0);
        assert_eq!(evaluation_of(&near), Some(EvaluationMethod::Root));
        let far = source([0.0; 3], [0.0, 0.0, 0.9], 60.0);
        assert_ne!(evaluation_of(&far), Some(EvaluationMethod::Root));
        // Nearer to the wall than the ray form allows, and outside: the forms themselves.
        for distance in [0.97, 2.0] {
            let outside = source([0.0; 3], [0.0, -0.5 * distance, 0.8 * distance], 20.0);
            assert!(evaluation_of(&outside) == Some(EvaluationMethod::Forms), "{distance}");
        }
    }

    #[test]
    fn what_f32_cannot_hold_is_a_table() {
        // The light passes a viewer near the screen: directions are small differences of positions.
        let towards = glam::DMat3::from_rotation_x(30f64.to_radians()) * DVec3::NEG_Z;
        let viewer = towards * 0.98;
        assert!(matches!(source(viewer.to_array(), [0.0; 3], 10.0), Source::Table(_)));
        assert!(matches!(source([0.0; 3], [0.0; 3], 10.0), Source::Projector(_)), "a viewer in the middle");
        // Pixels of 7e-7 radians cannot be distinguished where a direction is rounded to some 2e-7.
        assert!(matches!(source([0.0; 3], [0.0; 3], 0.01), Source::Table(_)));
        assert!(matches!(source([0.0; 3], [0.0; 3], 0.1), Source::Projector(_)));
    }
}
