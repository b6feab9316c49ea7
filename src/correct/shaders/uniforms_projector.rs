//! The constants of a projector's pass.

use crate::blend::{EdgeWeight, LEAST_RAMP};
use crate::correct::passes::output_pass::Batch;
use crate::correct::passes::source::{EvaluationMethod, ProjectorSource};
use crate::correct::shaders::constants::{Form, MAX_NEIGHBOURS, Neighbour, ProjectorConstants, Shared, Values, limit};
use crate::correct::shaders::polynomials::shape;
use crate::correct::single;
use crate::correct::sources::ray_form::RayForm;
use crate::error::{Error, ErrorKind, Result};
use crate::geom::QuadraticForm;
use crate::geom::screen::Join;
use glam::DMat3;

/// Returns the constants of a projector; `base`: viewer axes → base.
pub(super) fn values(source: &ProjectorSource, batch: &Batch, base: DMat3, shared_part: Shared) -> Result<Values> {
    limit("neighbours", batch.neighbours.len(), MAX_NEIGHBOURS)?;
    let evaluation = source.evaluation;
    let ray_form = RayForm::of(&source.pinhole)
        .filter(|_| matches!(evaluation, EvaluationMethod::Root | EvaluationMethod::Distance));
    let form = |form: &QuadraticForm| shader_form(form, evaluation, ray_form.as_ref());
    let discriminant = ray_form.as_ref().map_or(source.direction.d, RayForm::discriminant);
    let mut out = ProjectorConstants {
        shared_part,
        direction: form(&source.direction.transformed(base)),
        dome: form(&source.dome_direction),
        discriminant: quadratic_polynomial(&discriminant),
        evaluation: match evaluation {
            EvaluationMethod::Forms => 0,
            EvaluationMethod::Linear => 1,
            EvaluationMethod::Root => 2,
            EvaluationMethod::Distance => 3,
        },
        neighbour_count: batch.neighbours.len() as u32,
        border: border(&source.edge_weight),
        ..ProjectorConstants::default()
    };
    if let Some(rim) = source.rim.as_ref().filter(|_| batch.edge) {
        out.limits = form(&rim.limits);
        if let Some((sides, _)) = &rim.sides {
            out.sides = form(sides);
        }
        out.edge_test = match rim.sides {
            None => 1,
            Some((_, Join::Both)) => 2,
            Some((_, Join::Either)) => 3,
        };
    }
    for (to, &index) in out.neighbours.iter_mut().zip(&batch.neighbours) {
        let neighbour = source.neighbours.get(index).ok_or_else(|| {
            Error::new(ErrorKind::Internal, format!("A batch blends into neighbour {index}, which does not exist."))
        })?;
        *to = Neighbour { picture: form(&neighbour.picture), border: border(&neighbour.edge_weight) };
    }
    if let Some(ray_form) = ray_form.as_ref().filter(|_| evaluation == EvaluationMethod::Distance) {
        out.squared = quadratic_polynomial(&ray_form.squared);
        out.along = single::values(ray_form.along);
    }
    Ok(Values::Projector(Box::new(out)))
}

/// Returns a picture's border as the shaders take it: 1/(2·width), shape, exponent, black.
fn border(border: &EdgeWeight) -> [f32; 4] {
    single::values([0.5 / border.width.max(LEAST_RAMP), shape(border.shape), border.exponent, border.black])
}

/// Returns the coefficients of a form that the shaders read; the others are 0.
fn shader_form(form: &QuadraticForm, evaluation: EvaluationMethod, ray_form: Option<&RayForm>) -> Form {
    let linear =
        ray_form.filter(|_| evaluation == EvaluationMethod::Root).map_or(form.l, |ray_form| ray_form.freed(form));
    let [l_x, l_y, l_one] = [0, 1, 2].map(|k| single::values([0, 1, 2].map(|i: usize| linear[i][k])));
    let out = Form { l_x, l_y, l_one, ..Form::default() };
    match evaluation {
        EvaluationMethod::Forms => {
            // The order of the coefficients: x², y², xy, x, y, 1.
            let [q_xx, q_yy, q_xy, q_x, q_y, q_one] =
                [0, 1, 2, 3, 4, 5].map(|k| single::values([form.q[0][k], form.q[1][k], form.q[2][k]]));
            Form { q_xx, q_yy, q_xy, q_x, q_y, q_one, ..out }
        }
        EvaluationMethod::Linear => out,
        EvaluationMethod::Root | EvaluationMethod::Distance => {
            Form { offset: single::values(form.offset.to_array()), ..out }
        }
    }
}

/// Returns a quadratic polynomial of the pixel as the shaders take it.
fn quadratic_polynomial(coefficients: &[f64; 6]) -> [[f32; 4]; 2] {
    let [a, b, c, d, e, f] = single::values(*coefficients);
    [[a, b, c, d], [e, f, 0.0, 0.0]]
}
