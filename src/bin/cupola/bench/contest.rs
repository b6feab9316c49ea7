//! A scene and all methods on it: times and errors.

use super::methods::{Directions, add_all};
use super::scenes::Scene;
use crate::Failure;
use cupola::backend::gl::trial::{Times, Trial};
use cupola::warp::{MapError, WarpMap, compare_each};

/// What was measured on one scene.
pub struct Contest {
    /// The scene.
    pub scene: Scene,
    /// Who drew it.
    pub driver: String,
    /// The methods; the first is the unit of time.
    pub results: Vec<Outcome>,
}

/// What was measured of one method.
pub struct Outcome {
    /// In words.
    pub name: String,
    /// Ours, as it is without being asked for anything.
    pub is_default: bool,
    /// Median of its time over that of the first, round by round.
    pub ratio: f64,
    /// Quarter and three quarters of the same.
    pub spread: (f64, f64),
    /// The same for processor time.
    pub processor_ratio: f64,
    /// Median of the time, milliseconds.
    pub milliseconds: f64,
    /// Texels of the views that are drawn for it, over the output's pixels.
    pub texels: Option<f64>,
    /// Its error, if it corrects anything.
    pub error: Option<Errors>,
}

/// The error of a method's map.
pub struct Errors {
    /// Greatest, root mean square, and pixels that are wrong altogether.
    pub map: MapError,
    /// 99.9 % of the pixels are at most so wrong, output pixels.
    pub most: f64,
    /// Greatest angle, minutes of arc.
    pub minutes: f64,
    /// Error of each pixel, output pixels, row by row from the top; NaN where nothing is compared.
    pub pixels: Vec<f32>,
}

/// Measures all methods on `scene`; `phase` hears what is going on.
pub fn run(scene: Scene, rounds: u32, phase: impl Fn(String)) -> Result<Contest, Failure> {
    let mut trial = Trial::new(scene.size)?;
    let exact = WarpMap::new(&scene.rig, 0, scene.size, None)?;
    let methods = add_all(&mut trial, &scene, &exact)?;
    let mut round = 0;
    let times = trial.run(rounds, || {
        round += 1;
        phase(format!("{}: round {round}", scene.name));
    })?;
    phase(format!("{}: errors", scene.name));
    let base = &times[methods[0].number];
    let mut results = Vec::new();
    for method in methods {
        let own = &times[method.number];
        let ratios = sorted(own.seconds.iter().zip(&base.seconds).map(|(own, base)| own / base));
        results.push(Outcome {
            name: method.name,
            is_default: method.is_default,
            ratio: quantile(&ratios, 0.5),
            spread: (quantile(&ratios, 0.25), quantile(&ratios, 0.75)),
            processor_ratio: processor_ratio(own, base),
            milliseconds: quantile(&sorted(own.seconds.iter().copied()), 0.5) * 1e3,
            texels: method.texels,
            error: method.map.map(|map| errors(&exact, &map)),
        });
    }
    Ok(Contest { scene, driver: trial.driver(), results })
}

fn processor_ratio(own: &Times, base: &Times) -> f64 {
    quantile(&sorted(own.processor.iter().zip(&base.processor).map(|(own, base)| own / base)), 0.5)
}

fn errors(exact: &WarpMap, map: &Directions) -> Errors {
    let (width, height) = (exact.size().0 as usize, exact.size().1 as usize);
    let mut pixels = vec![f32::NAN; width * height];
    let (mut all, mut angle) = (Vec::new(), 0.0f64);
    let look = |x: u32, y: u32| map[y as usize * width + x as usize];
    let map = compare_each(exact, 1, look, |error| {
        pixels[error.pixel.1 as usize * width + error.pixel.0 as usize] = error.pixels as f32;
        all.push(error.pixels);
        angle = angle.max(error.angle);
    });
    Errors { map, most: quantile(&sorted(all.into_iter()), 0.999), minutes: angle.to_degrees() * 60.0, pixels }
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The value below which a part of the sorted values lies; NaN if there are none.
fn quantile(sorted: &[f64], part: f64) -> f64 {
    let index = (part * sorted.len() as f64) as usize;
    sorted.get(index.min(sorted.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
}
