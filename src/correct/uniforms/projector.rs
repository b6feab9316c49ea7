//! The constants of a projector's pass.

use super::{Constants, MAX_NEIGHBOURS, limit, shape};
use crate::blend::{Border, LEAST_RAMP};
use crate::correct::beam::{Beam, Way};
use crate::correct::plan::{Batch, ProjectorSource};
use crate::error::{Error, ErrorKind, Result};
use crate::geom::QuadraticForm;
use glam::{DMat3, DVec3};

/// Sets what only projectors have, for pictures of `size` pixels; `base`: viewer axes → base.
pub(super) fn set(
    out: &mut Constants,
    source: &ProjectorSource,
    size: (u32, u32),
    batch: &Batch,
    base: DMat3,
) -> Result<()> {
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
    let inside = Beam::of(source).and_then(|beam| {
        let way = beam.way(source, size)?;
        let offsets: Vec<DVec3> = forms.iter().map(|(_, form)| beam.offset(form)).collect::<Option<_>>()?;
        Some((beam, way, offsets))
    });
    if let Some((beam, way, offsets)) = inside {
        set_polynomial(out, "discriminant", &beam.discriminant())?;
        out.set("inside", &[if way == Way::Root { 1.0 } else { 2.0 }])?;
        if way == Way::Distance {
            set_polynomial(out, "squared", &beam.squared)?;
            out.set("along", &beam.along)?;
        }
        for ((path, form), offset) in forms.iter().zip(offsets) {
            out.set(&format!("{path}.offset"), &offset.to_array())?;
            let linear = if way == Way::Root { beam.freed(&form.l, offset) } else { form.l };
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
