//! Blend weights of overlapping projectors in f32, as shaders compute them, compared with f64.

use super::driver::Driver;
use super::maps;
use super::report::Finding;
use super::rigs;
use crate::failure::Failure;
use crate::random::Random;
use cupola::blend::Weights;
use glam::DVec2;
use std::f64::consts::FRAC_PI_4;

/// Bound on the error of a weight: half a step of 8 bits. The error is greatest where borders of
/// pictures cross and all weights are small.
const WEIGHT: f64 = 2e-3;

/// Distance in pixels around the centre of a pixel in which every exact weight counts as right.
/// Weights are discontinuous where borders of pictures cross.
const NEAR: f64 = 0.01;

/// Errors of the weights of one output of a random group of projectors. Empty if the driver
/// computes no weights.
pub fn case(random: &mut Random, driver: &Driver) -> Result<Vec<Finding>, Failure> {
    let case = rigs::overlapping(random)?;
    let size = maps::size(random);
    let sizes = vec![size; case.rig.outputs.len()];
    let output = (random.unit() * sizes.len() as f64) as usize;
    let refused =
        |failure: Failure| Failure::new(format!("{}\nsize {}x{}\n{}", failure.message, size.0, size.1, case.text));
    let map = maps::planned(&case.rig, &sizes).and_then(|plan| driver.map(&plan, output)).map_err(refused)?;
    let Some(map) = map else { return Ok(Vec::new()) };
    let exact = Weights::new(&case.rig, &sizes)?;
    let (mut worst, mut place, mut compared, mut wrong) = (0.0f64, (0, 0), 0, 0u64);
    for (index, pixel) in map.iter().enumerate() {
        let (x, y) = (index as u32 % size.0, index as u32 / size.0);
        let expected = exact.weight(output, DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let (Some(expected), Some(_)) = (expected, pixel.view) else { continue };
        compared += 1;
        let found = f64::from(pixel.weight);
        wrong += u64::from(!(0.0..=1.0).contains(&found));
        let mut error = (found - expected).abs();
        if error > WEIGHT {
            let [least, greatest] = around(&exact, output, (x, y)).unwrap_or([expected; 2]);
            error = error.min((least - found).max(found - greatest).max(0.0));
        }
        if error.is_nan() || error > worst {
            (worst, place) = (error, (x, y));
        }
    }
    let input = format!("output {output}, size {}x{}, pixel {place:?}\n{}", size.0, size.1, case.text);
    let finding =
        |quantity, value, bound| Finding { quantity, value, bound, compared, pixels: false, input: input.clone() };
    Ok(vec![
        finding("light: greatest error of a weight, beyond what is within 0.01 px", worst, WEIGHT),
        finding("light: weights outside 0…1", wrong as f64, 0.0),
    ])
}

/// The least and the greatest weight at the centre of a pixel and within [`NEAR`] of it; `None` if
/// nothing is shown.
fn around(exact: &Weights<'_>, output: usize, (x, y): (u32, u32)) -> Option<[f64; 2]> {
    let middle = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
    let here = exact.weight(output, middle)?;
    let aside = (0..8).map(|turn| DVec2::from_angle(f64::from(turn) * FRAC_PI_4) * NEAR);
    let weights = aside.filter_map(|aside| exact.weight(output, middle + aside));
    Some(weights.fold([here; 2], |[least, greatest], weight| [least.min(weight), greatest.max(weight)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The range of weights around a pixel is wider than the bound only where borders cross.
    #[test]
    fn what_is_right_around_a_pixel_hides_no_error() {
        let (size, mut compared, mut wide) = ((64, 64), 0, 0);
        for seed in 0..6 {
            let case = rigs::overlapping(&mut Random::new(seed)).expect("a rig");
            let sizes = vec![size; case.rig.outputs.len()];
            let exact = Weights::new(&case.rig, &sizes).expect("weights");
            for place in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
                let Some([least, greatest]) = around(&exact, 0, place) else { continue };
                assert!((0.0..=1.0).contains(&least) && least <= greatest && greatest <= 1.0, "{seed} {place:?}");
                compared += 1;
                wide += u32::from(greatest - least > 5.0 * WEIGHT);
            }
        }
        assert!(compared > 10_000 && wide * 50 < compared, "{wide} of {compared}");
    }
}
