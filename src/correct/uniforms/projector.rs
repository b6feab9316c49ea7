//! The constants of a projector's pass.

use super::{Constants, MAX_NEIGHBOURS, limit, shape};
use crate::blend::{Border, LEAST_RAMP};
use crate::correct::plan::{Batch, ProjectorSource};
use crate::error::{Error, ErrorKind, Result};
use crate::geom::QuadraticForm;
use glam::{DMat3, DVec3};

/// Sets what only projectors have; `base`: viewer axes → base.
pub(super) fn set(out: &mut Constants, source: &ProjectorSource, batch: &Batch, base: DMat3) -> Result<()> {
    limit("neighbours", batch.neighbours.len(), MAX_NEIGHBOURS)?;
    let d = source.direction.d;
    let mut forms = vec![("direction".to_owned(), source.direction.transformed(base))];
    forms.push(("dome".to_owned(), source.dome_direction));
    if let Some((q, l)) = source.cap {
        forms.push(("cap".to_owned(), QuadraticForm { q: [q, [0.0; 6], [0.0; 6]], l: [l, [0.0; 3], [0.0; 3]], d }));
        out.set_flag("with_cap", batch.edge)?;
    }
    for (i, &index) in batch.neighbours.iter().enumerate() {
        let neighbour = source.neighbours.get(index).ok_or_else(|| {
            Error::new(ErrorKind::Internal, format!("A batch blends into neighbour {index}, which is not there."))
        })?;
        forms.push((format!("neighbours[{i}].picture"), neighbour.picture));
        out.set(&format!("neighbours[{i}].border"), &border(&neighbour.border))?;
    }
    out.set("neighbour_count", &[batch.neighbours.len() as f64])?;
    out.set("border", &border(&source.border))?;
    let beam = Beam::of(source);
    let offsets: Option<Vec<DVec3>> = beam.as_ref().and_then(|b| forms.iter().map(|(_, f)| b.offset(f)).collect());
    if let (Some(beam), Some(offsets)) = (beam, offsets) {
        set_polynomial(out, "discriminant", &beam.discriminant())?;
        let well = beam.depth >= WELL_INSIDE * (beam.depth + source.position.length_squared());
        out.set("inside", &[if well { 1.0 } else { 2.0 }])?;
        if !well {
            set_polynomial(out, "squared", &beam.squared)?;
            out.set("along", &beam.along)?;
        }
        for ((path, form), offset) in forms.iter().zip(offsets) {
            out.set(&format!("{path}.offset"), &offset.to_array())?;
            let linear = if well { beam.freed(&form.l, offset) } else { form.l };
            linear_part(out, path, &linear, 1.0)?;
        }
    } else {
        set_polynomial(out, "discriminant", &d)?;
        for (path, form) in &forms {
            quadratic_part(out, path, form)?;
            linear_part(out, path, &form.l, shared_root(form.d, d)?)?;
        }
    }
    Ok(())
}

/// A picture's border as the shaders take it: 1/(2·width), shape, exponent, black.
fn border(border: &Border) -> [f64; 4] {
    [0.5 / border.width.max(LEAST_RAMP), shape(border.shape), border.exponent, border.black]
}

/// The rays `o + t·d` of a projector inside the sphere, from which its forms follow with fewer operations. Each
/// form is `offset·a + linear·(√D − b)`, with `a = d·d`, `b = o·d`, `D = b² + depth·a`. Since
/// `(√D − b)·(√D + b) = depth·a`, the same direction is `offset·(√D + b) + linear·depth`, and, b being linear in
/// the pixel, `offset·√D` plus a linear function: one root is all that is not linear.
///
/// Near the sphere `√D + b` cancels; `offset/t + linear`, with `1/t = a/(√D − b)`, does not. Farther out `D` itself
/// cancels, and only the forms' own coefficients, which are rounded after the cancellation, are exact.
struct Beam {
    /// a = d·d over `[x², y², xy, x, y, 1]`.
    squared: [f64; 6],
    /// b = o·d over `[x, y, 1]`.
    along: [f64; 3],
    /// R² − o·o, > 0.
    depth: f64,
}

/// Inside the sphere, as the forms take it: up to this part of its radius.
const INSIDE: f64 = 0.95;
/// Well inside: `(R² − o²)/R²` is at least this.
const WELL_INSIDE: f64 = 0.36;

impl Beam {
    fn of(source: &ProjectorSource) -> Option<Self> {
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

    fn discriminant(&self) -> [f64; 6] {
        let b = times(&self.along, &self.along);
        std::array::from_fn(|k| b[k] + self.depth * self.squared[k])
    }

    /// A form's linear part once it is freed of a and b.
    fn freed(&self, linear: &[[f64; 3]; 3], offset: DVec3) -> [[f64; 3]; 3] {
        [0, 1, 2].map(|i| std::array::from_fn(|k| linear[i][k] * self.depth + offset[i] * self.along[k]))
    }

    /// What multiplies a in a form of this projector; `None` where it is none.
    fn offset(&self, form: &QuadraticForm) -> Option<DVec3> {
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

/// Sets a form's quadratic part. The order of its coefficients: x², y², xy, x, y, 1.
fn quadratic_part(out: &mut Constants, path: &str, form: &QuadraticForm) -> Result<()> {
    for (k, name) in ["q_xx", "q_yy", "q_xy", "q_x", "q_y", "q_one"].into_iter().enumerate() {
        out.set(&format!("{path}.{name}"), &[form.q[0][k], form.q[1][k], form.q[2][k]])?;
    }
    Ok(())
}

/// Sets a quadratic polynomial of the pixel.
fn set_polynomial(out: &mut Constants, path: &str, coefficients: &[f64; 6]) -> Result<()> {
    out.set(&format!("{path}[0]"), &coefficients[..4])?;
    out.set(&format!("{path}[1]"), &[coefficients[4], coefficients[5], 0.0, 0.0])
}

/// Sets a form's linear part, times `factor`.
fn linear_part(out: &mut Constants, path: &str, linear: &[[f64; 3]; 3], factor: f64) -> Result<()> {
    for (k, name) in ["l_x", "l_y", "l_one"].into_iter().enumerate() {
        out.set(&format!("{path}.{name}"), &[0, 1, 2].map(|i| linear[i][k] * factor))?;
    }
    Ok(())
}

/// √(own/shared) of two discriminants, which must be in proportion.
fn shared_root(own: [f64; 6], shared: [f64; 6]) -> Result<f64> {
    let largest = (0..6).max_by(|a, b| shared[*a].abs().total_cmp(&shared[*b].abs())).unwrap_or(0);
    let factor = if shared[largest] == 0.0 { 1.0 } else { own[largest] / shared[largest] };
    let size = own[largest].abs();
    let alike = own.iter().zip(&shared).all(|(a, b)| (a - factor * b).abs() <= 1e-9 * size);
    if alike && factor >= 0.0 {
        Ok(factor.sqrt())
    } else {
        Err(Error::new(ErrorKind::Internal, "The forms of one projector's pixel differ in their discriminants."))
    }
}
