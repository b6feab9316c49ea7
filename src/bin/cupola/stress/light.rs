//! The weights of overlapping projectors as shaders compute them, against f64.

use super::Finding;
use super::driver::Driver;
use super::maps;
use super::rigs;
use crate::Failure;
use cupola::blend::Weights;
use cupola::geom::random::Random;
use glam::DVec2;

/// Greatest error of a weight: half a step of 8 bits. It is neared where borders of pictures cross and all
/// weights are small.
const WEIGHT: f64 = 2e-3;

/// How right the weights of one output of a random group of projectors are; nothing where none are computed.
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
        let error = (found - expected).abs();
        if error.is_nan() || error > worst {
            (worst, place) = (error, (x, y));
        }
    }
    let input = format!("output {output}, size {}x{}, pixel {place:?}\n{}", size.0, size.1, case.text);
    let finding =
        |quantity, value, bound| Finding { quantity, value, bound, compared, pixels: false, input: input.clone() };
    Ok(vec![
        finding("light: greatest error of a weight", worst, WEIGHT),
        finding("light: weights outside 0…1", wrong as f64, 0.0),
    ])
}
