//! Error of a projector's formula by rounding to f32, estimated in f64 before there is a shader.
//!
//! Each term of a sum is rounded to a part of its own size. Where terms cancel, as they do when the
//! viewer is near the lit screen or the projector near the wall behind it, the sum is small and its
//! error is not.

use crate::correct::passes::source::ProjectorSource;
use crate::correct::passes::tolerance::{ANGLE, OWN_PIXELS, PIXELS, REFERENCE};
use crate::geom::QuadraticForm;
use crate::geom::quadratic::{linear_at, quadratic_at};
use glam::DVec3;

/// Rounding error of a sum relative to its terms: about three half steps of f32. With hundreds of
/// random rigs, the error of a driver was 0.25 to 1.07 times the estimate where the estimate was
/// near the limit.
const STEP: f64 = 2e-7;
/// Greatest allowed motion of a rim, pixels.
const RIM: f64 = 0.01;
/// Places in each direction where the error is estimated.
const PLACES: u32 = 17;

/// A sum of vectors, and the size of its terms, component by component.
#[derive(Clone, Copy, Debug)]
pub(in crate::correct) struct Sum {
    pub value: DVec3,
    pub terms: DVec3,
}

/// True if rounding moves directions and rims of `source` only little in a picture of `size`
/// pixels. `sum`: the way in which its forms are summed. Directions may move by 0.002 pixels of a
/// picture 4096 wide, or by 6·10⁻⁷ radians, whichever is more, but by at most a quarter of the
/// picture's own pixels. Rims may move by a hundredth of these.
pub(in crate::correct) fn is_exact(
    source: &ProjectorSource,
    size: (u32, u32),
    sum: impl Fn(&QuadraticForm, f64, f64) -> Option<Sum>,
) -> bool {
    let (width, height) = (f64::from(size.0.max(1)), f64::from(size.1.max(1)));
    let scale = width.max(height) / REFERENCE;
    // Normalised coordinates of a pixel of the reference's size.
    let (across, up) = (2.0 * scale / width, 2.0 * scale / height);
    let place = |i: u32| 2.0 * f64::from(i) / f64::from(PLACES - 1) - 1.0;
    let at = |i: u32| (place(i % PLACES), place(i / PLACES));
    let shown: Vec<bool> = (0..PLACES * PLACES).map(|i| source.direction(at(i).0, at(i).1).is_some()).collect();
    // True for places that are shown, or next to one that is: rims are between them.
    let near = |i: u32| {
        let around = |k: u32| k.saturating_sub(1)..(k + 2).min(PLACES);
        around(i / PLACES).any(|row| around(i % PLACES).any(|column| shown[(row * PLACES + column) as usize]))
    };
    for i in (0..PLACES * PLACES).filter(|i| near(*i)) {
        let (x, y) = at(i);
        let Some(Sum { value, terms }) = sum(&source.direction, x, y) else { continue };
        let angle = |dx: f64, dy: f64| {
            let seen = |side: f64| source.pinhole.evaluate(&source.direction, x + side * dx, y + side * dy);
            let (a, b) = (seen(-0.5)?, seen(0.5)?);
            Some(a.cross(b).length().atan2(a.dot(b)))
        };
        let (Some(h), Some(v)) = (angle(across, 0.0), angle(0.0, up)) else { continue };
        let pixel = (0.5 * (h * h + v * v)).sqrt();
        let spread = terms.length() / value.length();
        let rims =
            source.rim.iter().flat_map(|rim| std::iter::once(&rim.limits).chain(rim.sides.as_ref().map(|s| &s.0)));
        let within = STEP * spread <= (PIXELS * pixel).max(ANGLE.min(OWN_PIXELS * pixel / scale))
            && rims.into_iter().all(|rim| is_sharp(rim, (x, y), (2.0 / width, 2.0 / height), &sum));
        if !within {
            return false;
        }
    }
    true
}

/// True if rounding moves a rim that passes near a place by less than [`RIM`] pixels; `pixel` in
/// normalised coordinates.
fn is_sharp(
    rim: &QuadraticForm,
    (x, y): (f64, f64),
    pixel: (f64, f64),
    sum: &impl Fn(&QuadraticForm, f64, f64) -> Option<Sum>,
) -> bool {
    let here = sum(rim, x, y);
    let (right, above) = (sum(rim, x + pixel.0, y), sum(rim, x, y + pixel.1));
    let (Some(here), Some(right), Some(above)) = (here, right, above) else { return true };
    let (across, up) = (right.value - here.value, above.value - here.value);
    (0..3).all(|i| {
        let slope = across[i].hypot(up[i]);
        // Distance to the next place, in pixels.
        let apart = 2.0 / f64::from(PLACES - 1) / pixel.0.min(pixel.1);
        here.value[i].abs() > slope * apart || STEP * here.terms[i] <= RIM * slope
    })
}

/// Returns the sum of a form as written: quadratic part and linear part times the root. `None`
/// where the ray misses.
pub(in crate::correct) fn of_form(form: &QuadraticForm, x: f64, y: f64) -> Option<Sum> {
    let value = form.evaluate(x, y)?;
    let (root, from_root) = root(&form.d, x, y);
    let component = |i: usize| {
        let linear = linear_at(&form.l[i], x, y).abs();
        quadratic_terms(&form.q[i], x, y) + linear_terms(&form.l[i], x, y) * root + linear * from_root
    };
    Some(Sum { value, terms: DVec3::new(component(0), component(1), component(2)) })
}

/// Returns the root of a polynomial ≥ 0, and the size of its terms as far as they move the root.
pub(in crate::correct) fn root(polynomial: &[f64; 6], x: f64, y: f64) -> (f64, f64) {
    let root = quadratic_at(polynomial, x, y).max(0.0).sqrt();
    (root, 0.5 * quadratic_terms(polynomial, x, y) / root.max(f64::MIN_POSITIVE))
}

/// Returns the size of the terms of a quadratic polynomial over `[x², y², xy, x, y, 1]`.
pub(in crate::correct) fn quadratic_terms(c: &[f64; 6], x: f64, y: f64) -> f64 {
    quadratic_at(&c.map(f64::abs), x.abs(), y.abs())
}

/// Returns the size of the terms of a linear polynomial over `[x, y, 1]`.
pub(in crate::correct) fn linear_terms(c: &[f64; 3], x: f64, y: f64) -> f64 {
    linear_at(&c.map(f64::abs), x.abs(), y.abs())
}
