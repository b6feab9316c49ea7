//! The constants of a projector's pass.

use crate::blend::{Border, LEAST_RAMP};
use crate::correct::passes::output_pass::Batch;
use crate::correct::passes::source::{ProjectorSource, Way};
use crate::correct::shaders::constants::{Form, MAX_NEIGHBOURS, Neighbour, ProjectorConstants, Shared, Values, limit};
use crate::correct::shaders::polynomials::shape;
use crate::correct::single;
use crate::correct::sources::ray_form::Beam;
use crate::error::{Error, ErrorKind, Result};
use crate::geom::QuadraticForm;
use crate::geom::screen::Join;
use glam::DMat3;

/// Returns the constants of a projector; `base`: viewer axes → base.
pub(super) fn values(source: &ProjectorSource, batch: &Batch, base: DMat3, shared_part: Shared) -> Result<Values> {
    limit("neighbours", batch.neighbours.len(), MAX_NEIGHBOURS)?;
    let way = source.way;
    let beam = Beam::of(&source.pencil).filter(|_| matches!(way, Way::Root | Way::Distance));
    let form = |form: &QuadraticForm| shader_form(form, way, beam.as_ref());
    let discriminant = beam.as_ref().map_or(source.direction.d, Beam::discriminant);
    let mut out = ProjectorConstants {
        shared_part,
        direction: form(&source.direction.transformed(base)),
        dome: form(&source.dome_direction),
        discriminant: quadratic_polynomial(&discriminant),
        way: match way {
            Way::Forms => 0,
            Way::Linear => 1,
            Way::Root => 2,
            Way::Distance => 3,
        },
        neighbour_count: batch.neighbours.len() as u32,
        border: border(&source.border),
        ..ProjectorConstants::default()
    };
    if let Some(rim) = source.rim.as_ref().filter(|_| batch.edge) {
        out.limits = form(&rim.limits);
        if let Some((sides, _)) = &rim.sides {
            out.sides = form(sides);
        }
        out.rim = match rim.sides {
            None => 1,
            Some((_, Join::Both)) => 2,
            Some((_, Join::Either)) => 3,
        };
    }
    for (to, &index) in out.neighbours.iter_mut().zip(&batch.neighbours) {
        let neighbour = source.neighbours.get(index).ok_or_else(|| {
            Error::new(ErrorKind::Internal, format!("A batch blends into neighbour {index}, which is not there."))
        })?;
        *to = Neighbour { picture: form(&neighbour.picture), border: border(&neighbour.border) };
    }
    if let Some(beam) = beam.as_ref().filter(|_| way == Way::Distance) {
        out.squared = quadratic_polynomial(&beam.squared);
        out.along = single::values(beam.along);
    }
    Ok(Values::Projector(Box::new(out)))
}

/// A picture's border as the shaders take it: 1/(2·width), shape, exponent, black.
fn border(border: &Border) -> [f32; 4] {
    single::values([0.5 / border.width.max(LEAST_RAMP), shape(border.shape), border.exponent, border.black])
}

/// The coefficients of a form that the shaders read; the others are 0.
fn shader_form(form: &QuadraticForm, way: Way, beam: Option<&Beam>) -> Form {
    let linear = beam.filter(|_| way == Way::Root).map_or(form.l, |beam| beam.freed(form));
    let [l_x, l_y, l_one] = [0, 1, 2].map(|k| single::values([0, 1, 2].map(|i: usize| linear[i][k])));
    let out = Form { l_x, l_y, l_one, ..Form::default() };
    match way {
        Way::Forms => {
            // The order of the coefficients: x², y², xy, x, y, 1.
            let [q_xx, q_yy, q_xy, q_x, q_y, q_one] =
                [0, 1, 2, 3, 4, 5].map(|k| single::values([form.q[0][k], form.q[1][k], form.q[2][k]]));
            Form { q_xx, q_yy, q_xy, q_x, q_y, q_one, ..out }
        }
        Way::Linear => out,
        Way::Root | Way::Distance => Form { offset: single::values(form.offset.to_array()), ..out },
    }
}

/// A quadratic polynomial of the pixel as the shaders take it.
fn quadratic_polynomial(coefficients: &[f64; 6]) -> [[f32; 4]; 2] {
    let [a, b, c, d, e, f] = single::values(*coefficients);
    [[a, b, c, d], [e, f, 0.0, 0.0]]
}
