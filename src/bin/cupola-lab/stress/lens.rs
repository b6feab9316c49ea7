//! Lenses recovered from products in f32 of projection, view and model matrices.

use super::case::pick;
use super::clip::single;
use super::report::Finding;
use crate::random::Random;
use cupola::geom::reprojection::{MatrixClass, classify};
use glam::{DMat3, DMat4, DVec3, DVec4};

/// Number of matrices of a case.
const MATRICES: u64 = 500;

/// Bound on the relative error of A and C and on the absolute error of B, D and E.
const LENS: f64 = 7e-7;

/// The worst of the products of one random lens.
pub fn case(random: &mut Random) -> Vec<Finding> {
    let [a, c] = [random.range(0.5, 4.0), random.range(0.5, 4.0)].map(single);
    let [b, d] = [random.range(-0.5, 0.5), random.range(-0.5, 0.5)].map(single);
    let e = single(pick(random, &[-1.0, -1.000_2, -1.02]));
    let projection = DMat4::from_cols(
        DVec4::new(a, 0.0, 0.0, 0.0),
        DVec4::new(0.0, c, 0.0, 0.0),
        DVec4::new(b, d, e, -1.0),
        DVec4::new(0.0, 0.0, -0.2, 0.0),
    );
    let (mut worst, mut unknown, mut input) = (0.0f64, 0u64, String::new());
    for _ in 0..MATRICES {
        let mirror = if random.unit() < 0.25 { DVec3::new(-1.0, 1.0, 1.0) } else { DVec3::ONE };
        let scale = 10f64.powf(random.range(-3.0, 3.0));
        let far = 10f64.powf(random.range(-2.0, 6.0));
        let model = DMat4::from_translation(random.direction() * far)
            * DMat4::from_mat3(random.rotation() * DMat3::from_diagonal(mirror * scale));
        let given = product(projection, model);
        let MatrixClass::Perspective(found) = classify(&given) else {
            unknown += 1;
            input = format!("not recognised: {given:?}");
            continue;
        };
        let relative = ((found.a - a) / a).abs().max(((found.c - c) / c).abs());
        let absolute = (found.b - b).abs().max((found.d - d).abs()).max((found.e - e).abs());
        let error = relative.max(absolute);
        if error.is_nan() || error > worst {
            worst = error;
            if unknown == 0 {
                input = format!("{given:?}");
            }
        }
    }
    let finding = |quantity, value, bound| Finding {
        quantity,
        value,
        bound,
        compared: MATRICES,
        pixels: false,
        input: input.clone(),
    };
    vec![
        finding("lens: error of A, C (relative), B, D, E (absolute)", worst, LENS),
        finding("lens: projections not recognised", unknown as f64, 0.0),
    ]
}

/// The product of two matrices, with every operation in f32 as in a program.
fn product(a: DMat4, b: DMat4) -> DMat4 {
    let (a, b) = (a.to_cols_array().map(|x| x as f32), b.to_cols_array().map(|x| x as f32));
    let entry = |i: usize| f64::from((0..4).map(|k| a[4 * k + i % 4] * b[4 * (i / 4) + k]).sum::<f32>());
    DMat4::from_cols_array(&std::array::from_fn(entry))
}
