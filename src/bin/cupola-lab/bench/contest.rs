//! Measurement of all methods on one scene.

use super::methods::{Clock, Directions, Entrants, Method};
use super::quality::{self, Quality};
use super::scenes::Scene;
use crate::failure::Failure;
use crate::trial::{self, gl::Times};
use cupola::warp::{MapError, TracedMap, WarpMap};
use std::time::Instant;

/// Results for one scene.
pub struct Contest {
    /// The scene.
    pub scene: Scene,
    /// Name of the driver.
    pub driver: String,
    /// Results of the methods. The time of the first is the unit of time.
    pub results: Vec<Outcome>,
}

/// Results of one method.
pub struct Outcome {
    /// Name of the method.
    pub name: String,
    /// True if this is Cupola's default.
    pub is_default: bool,
    /// Median over the rounds of its time divided by that of the first method.
    pub ratio: f64,
    /// First and third quartile of the same.
    pub spread: (f64, f64),
    /// The same for processor time.
    pub processor_ratio: f64,
    /// Median of the time in milliseconds.
    pub milliseconds: f64,
    /// Number of texels of the views that it needs, divided by the number of output pixels.
    pub texels: Option<f64>,
    /// Error of its map; `None` for methods that correct nothing.
    pub error: Option<Errors>,
    /// Quality of its picture of a scene with hard edges, drawn with four samples per texel,
    /// compared with many samples per pixel.
    pub quality: Option<Quality>,
}

/// Error of the map of a method.
pub struct Errors {
    /// Greatest error, root mean square, and numbers of wrong pixels.
    pub map: MapError,
    /// 99.9th percentile of the error in output pixels.
    pub most: f64,
    /// Greatest error in minutes of arc.
    pub minutes: f64,
    /// Error of each pixel in output pixels, row by row from the top; NaN for pixels that are not
    /// compared.
    pub pixels: Vec<f32>,
}

/// Measures all methods on `scene`. `phase` is called with a description of the current step.
pub fn run(scene: Scene, rounds: u32, phase: impl Fn(String)) -> Result<Contest, Failure> {
    let exact = TracedMap::new(WarpMap::new(&scene.rig, 0, scene.size, None)?);
    let Entrants { mut trial, mut vulkan, methods, .. } = Entrants::new(&scene, &exact)?;
    let mut round = 0;
    let mut others: Vec<Vec<f64>> = methods.iter().map(|_| Vec::new()).collect();
    let mut failed = None;
    let times = trial.run(rounds, || {
        round += 1;
        phase(format!("{}: round {round}", scene.name));
        // Methods that do not use OpenGL, in the same round.
        for (method, seconds) in methods.iter().zip(&mut others) {
            match time(method, vulkan.as_mut()) {
                Ok(taken) => seconds.extend(taken),
                Err(error) => failed = Some(error),
            }
        }
    })?;
    if let Some(error) = failed {
        return Err(error);
    }
    phase(format!("{}: pictures", scene.name));
    let truth = (scene.rig.outputs.len() == 1).then(|| quality::truth(exact.exact()));
    phase(format!("{}: errors", scene.name));
    let base = &times[0];
    let mut results = Vec::new();
    for (method, other) in methods.into_iter().zip(others) {
        let own = match &method.clock {
            Clock::OpenGl(number) => times[*number].clone(),
            // Without the warm-up rounds.
            _ => Times { seconds: other[other.len() - base.seconds.len()..].to_vec(), processor: Vec::new() },
        };
        let ratios = sorted(own.seconds.iter().zip(&base.seconds).map(|(own, base)| own / base));
        let picture = truth.as_ref().zip(method.picture(&trial)?);
        results.push(Outcome {
            is_default: method.is_default,
            ratio: quantile(&ratios, 0.5),
            spread: (quantile(&ratios, 0.25), quantile(&ratios, 0.75)),
            processor_ratio: processor_ratio(&own, base),
            milliseconds: quantile(&sorted(own.seconds.iter().copied()), 0.5) * 1e3,
            texels: method.texels,
            quality: picture.map(|(truth, picture)| quality::quality(&picture, truth, scene.size.0 as usize)),
            error: method.map.map(|map| errors(&exact, &map)),
            name: method.name,
        });
    }
    Ok(Contest { driver: trial.driver(), scene, results })
}

/// Time in seconds of a method that does not use OpenGL; `None` for other methods.
fn time(method: &Method, vulkan: Option<&mut trial::vk::Trial>) -> Result<Option<f64>, Failure> {
    Ok(match (&method.clock, vulkan) {
        (Clock::Vulkan(number), Some(vulkan)) => Some(vulkan.time(*number)?),
        (Clock::Processor(processor), _) => {
            let started = Instant::now();
            // The time to measure is that of the picture.
            std::hint::black_box(processor.picture());
            Some(started.elapsed().as_secs_f64())
        }
        _ => None,
    })
}

fn processor_ratio(own: &Times, base: &Times) -> f64 {
    quantile(&sorted(own.processor.iter().zip(&base.processor).map(|(own, base)| own / base)), 0.5)
}

fn errors(exact: &TracedMap, map: &Directions) -> Errors {
    let (width, height) = (exact.exact().size().0 as usize, exact.exact().size().1 as usize);
    let mut pixels = vec![f32::NAN; width * height];
    let (mut all, mut angle) = (Vec::new(), 0.0f64);
    let look = |x: u32, y: u32| map[y as usize * width + x as usize];
    let map = exact.compare_each(1, look, |error| {
        pixels[error.pixel.1 as usize * width + error.pixel.0 as usize] = error.pixels as f32;
        all.push(error.pixels);
        angle = angle.max(error.angle);
    });
    Errors { map, most: quantile(&sorted(all.into_iter()), 0.999), minutes: angle.to_degrees() * 60.0, pixels }
}

/// Values in ascending order.
pub fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The quantile `part` of sorted values; NaN if there are none.
pub fn quantile(sorted: &[f64], part: f64) -> f64 {
    let index = (part * sorted.len() as f64) as usize;
    sorted.get(index.min(sorted.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
}
