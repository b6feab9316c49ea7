//! How far rounding to f32 moves what a projector's formula shows: estimated in f64, before there is a shader.
//!
//! Each term of a sum is rounded to a part of its own size. Where terms cancel, as they do when the viewer is near the
//! lit screen or the projector near the wall behind it, the sum is small and its error is not.

use crate::geom::QuadraticForm;
use crate::geom::quadratic::{linear_at, quadratic_at, row_at};
use glam::DVec3;

/// Width of the picture in whose pixels errors are estimated: what a small picture shows is then held to what a large one needs.
const REFERENCE: f64 = 4096.0;
/// The error that is allowed, in such pixels.
const PIXELS: f64 = 0.002;
/// An angle that is allowed however narrow the pixels, radians: ten steps of f32.
const ANGLE: f64 = 6e-7;
/// What rounding does to a sum, as a part of its terms: some three half steps of f32. With hundreds of random rigs a driver
/// came to 0.25 to 0.95 times the estimate where that is near what is allowed.
const STEP: f64 = 2e-7;
/// Places in each direction where the error is estimated.
const PLACES: u32 = 5;

/// A sum of vectors and how large its terms are, component by component.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum {
    pub value: DVec3,
    pub terms: DVec3,
}

/// The greatest estimated error over that which is allowed (0.002 pixels of a picture 4096 wide, or 6·10⁻⁷ radians,
/// whichever is more), for a picture of `size` pixels in which `form` says what is shown, `cap` how much of it is
/// screen, and `sum` how the shader computes it.
pub(super) fn excess(
    form: &QuadraticForm,
    cap: Option<&([f64; 6], [f64; 3])>,
    size: (u32, u32),
    sum: impl Fn(f64, f64) -> Option<Sum>,
) -> f64 {
    let (width, height) = (f64::from(size.0.max(1)), f64::from(size.1.max(1)));
    let scale = width.max(height) / REFERENCE;
    // Normalised coordinates of a pixel of the reference's size.
    let (across, up) = (2.0 * scale / width, 2.0 * scale / height);
    let place = |i: u32| 2.0 * f64::from(i) / f64::from(PLACES - 1) - 1.0;
    let at = |i: u32| {
        let (x, y) = (place(i % PLACES), place(i / PLACES));
        let shown = cap.is_none_or(|row| row_at(row, form.discriminant(x, y), x, y) >= 0.0);
        let Sum { value, terms } = sum(x, y).filter(|_| shown)?;
        let angle = |dx: f64, dy: f64| {
            let (a, b) = (form.evaluate(x - 0.5 * dx, y - 0.5 * dy)?, form.evaluate(x + 0.5 * dx, y + 0.5 * dy)?);
            Some(a.cross(b).length().atan2(a.dot(b)))
        };
        let (h, v) = (angle(across, 0.0)?, angle(0.0, up)?);
        let pixel = (0.5 * (h * h + v * v)).sqrt();
        Some(STEP * terms.length() / value.length() / (PIXELS * pixel).max(ANGLE))
    };
    (0..PLACES * PLACES).filter_map(at).fold(0.0, f64::max)
}

/// The sum of a form as it stands: quadratic part and linear part times the root. `None` where the ray misses.
pub(super) fn of_form(form: &QuadraticForm, x: f64, y: f64) -> Option<Sum> {
    let value = form.evaluate(x, y)?;
    let (root, from_root) = root(&form.d, x, y);
    let component = |i: usize| {
        let linear = linear_at(&form.l[i], x, y).abs();
        quadratic_terms(&form.q[i], x, y) + linear_terms(&form.l[i], x, y) * root + linear * from_root
    };
    Some(Sum { value, terms: DVec3::new(component(0), component(1), component(2)) })
}

/// The root of a polynomial ≥ 0, and the size of its terms as far as they move the root.
pub(super) fn root(polynomial: &[f64; 6], x: f64, y: f64) -> (f64, f64) {
    let root = quadratic_at(polynomial, x, y).max(0.0).sqrt();
    (root, 0.5 * quadratic_terms(polynomial, x, y) / root.max(f64::MIN_POSITIVE))
}

/// The size of the terms of a quadratic polynomial over `[x², y², xy, x, y, 1]`.
pub(super) fn quadratic_terms(c: &[f64; 6], x: f64, y: f64) -> f64 {
    quadratic_at(&c.map(f64::abs), x.abs(), y.abs())
}

/// The size of the terms of a linear polynomial over `[x, y, 1]`.
pub(super) fn linear_terms(c: &[f64; 3], x: f64, y: f64) -> f64 {
    linear_at(&c.map(f64::abs), x.abs(), y.abs())
}
