//! The constants of a projector's pass.

use crate::blend::{Border, LEAST_RAMP};
use crate::correct::passes::output_pass::Batch;
use crate::correct::passes::source::ProjectorSource;
use crate::correct::passes::source::Way;
use crate::correct::shaders::uniforms::{Constants, MAX_NEIGHBOURS, limit, shape};
use crate::correct::sources::ray_form::Beam;
use crate::error::{Error, ErrorKind, Result};
use crate::geom::QuadraticForm;
use crate::geom::screen::Join;
use glam::DMat3;

/// Sets what only projectors have; `base`: viewer axes → base.
pub(in crate::correct) fn set(out: &mut Constants, source: &ProjectorSource, batch: &Batch, base: DMat3) -> Result<()> {
    limit("neighbours", batch.neighbours.len(), MAX_NEIGHBOURS)?;
    let mut forms = vec![("direction".to_owned(), source.direction.transformed(base))];
    forms.push(("dome".to_owned(), source.dome_direction));
    if let Some(rim) = source.rim.as_ref().filter(|_| batch.edge) {
        forms.push(("limits".to_owned(), rim.limits));
        forms.extend(rim.sides.map(|(sides, _)| ("sides".to_owned(), sides)));
        out.set(
            "rim",
            &[match rim.sides {
                None => 1.0,
                Some((_, Join::Both)) => 2.0,
                Some((_, Join::Either)) => 3.0,
            }],
        )?;
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
    let way = source.way;
    out.set(
        "way",
        &[match way {
            Way::Forms => 0.0,
            Way::Linear => 1.0,
            Way::Root => 2.0,
            Way::Distance => 3.0,
        }],
    )?;
    let beam = Beam::of(&source.pencil).filter(|_| matches!(way, Way::Root | Way::Distance));
    let discriminant = beam.as_ref().map_or(source.direction.d, Beam::discriminant);
    set_polynomial(out, "discriminant", &discriminant)?;
    if let Some(beam) = beam.as_ref().filter(|_| way == Way::Distance) {
        set_polynomial(out, "squared", &beam.squared)?;
        out.set("along", &beam.along)?;
    }
    for (path, form) in &forms {
        match way {
            Way::Forms => quadratic_part(out, path, form)?,
            Way::Linear => {}
            Way::Root | Way::Distance => out.set(&format!("{path}.offset"), &form.offset.to_array())?,
        }
        let linear = beam.as_ref().filter(|_| way == Way::Root).map_or(form.l, |beam| beam.freed(form));
        linear_part(out, path, &linear)?;
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

/// Sets a form's linear part.
fn linear_part(out: &mut Constants, path: &str, linear: &[[f64; 3]; 3]) -> Result<()> {
    for (k, name) in ["l_x", "l_y", "l_one"].into_iter().enumerate() {
        out.set(&format!("{path}.{name}"), &[0, 1, 2].map(|i| linear[i][k]))?;
    }
    Ok(())
}
