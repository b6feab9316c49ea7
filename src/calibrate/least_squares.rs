//! Non-linear least squares after Levenberg (1944) and Marquardt (1963), and a robust form of it
//! for observations of which some are wrong.
//!
//! The robust form minimises Tukey's biweight of the residuals over their scale, which follows from
//! the median residual of each group of observations (Huber and Ronchetti, *Robust Statistics*,
//! 2009). An observation farther away than [`CUT`] scales has no influence.

use super::Symmetric;
use glam::DVec2;

/// Residuals of observations in two dimensions as functions of parameters. Parameters have natural
/// units, so that a step of 1e-6 is small and is felt.
pub trait Model {
    /// Values that are computed once for a set of parameters.
    type State;
    /// Number of parameters.
    fn parameters(&self) -> usize;
    /// Number of observations.
    fn observations(&self) -> usize;
    /// Computes the values that the residuals need.
    fn state(&self, parameters: &[f64]) -> Self::State;
    /// Residual of an observation; `None` where the parameters give none.
    fn residual(&self, state: &Self::State, observation: usize) -> Option<DVec2>;
    /// Parameters on which an observation depends.
    fn depends(&self, observation: usize) -> impl Iterator<Item = usize>;
    /// True if a parameter is held at its value. No observation depends on it then.
    fn is_held(&self, _parameter: usize) -> bool {
        false
    }
    /// Group of an observation, 0…[`Self::groups`]. The observations of a group are equally
    /// precise. No group counts as more precise than group 0: a small group would only seem to be,
    /// because the parameters follow it.
    fn group(&self, _observation: usize) -> usize {
        0
    }
    /// Number of groups.
    fn groups(&self) -> usize {
        1
    }
    /// Set of an observation, 0…[`Self::sets`]. A set has parameters of its own, so that it may be far from its place
    /// when the other sets of its group fit already. More than half of each set is right.
    fn set(&self, _observation: usize) -> usize {
        0
    }
    /// Number of sets.
    fn sets(&self) -> usize {
        1
    }
}

/// Parameters of a fit, and their quality.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The parameters.
    pub parameters: Vec<f64>,
    /// The residual of each observation.
    pub residuals: Vec<Option<DVec2>>,
    /// True for each observation that had an influence.
    pub used: Vec<bool>,
    /// Sum of the losses and of the logarithms of the scales. Of two fits of the same observations,
    /// the better one has the lower cost.
    pub cost: f64,
    /// Standard deviation of a residual's coordinate, for each group.
    pub deviations: Vec<f64>,
    /// Covariance of the parameters; `None` where the observations do not determine them.
    pub covariance: Option<Symmetric>,
}

/// Number of scales beyond which an observation has no influence. A normally distributed error in
/// two dimensions is larger with a probability of e⁻¹⁸.
pub const CUT: f64 = 6.0;
/// Median length of a normally distributed error in two dimensions, in standard deviations: √(2 ln
/// 2).
const MEDIAN_LENGTH: f64 = 1.177_410_022_515_474_7;
/// Smallest scale: exact observations have rounding errors.
const LEAST_SCALE: f64 = 1e-5;
/// Step of central differences.
const STEP: f64 = 1e-6;
/// Information about a parameter that is held.
const KNOWN: f64 = 1e30;
/// Greatest number of minimisations, each with a new scale.
const ROUNDS: usize = 12;
/// Greatest number of steps of a minimisation, and of the last one.
const STEPS: usize = 10;
const LAST_STEPS: usize = 40;

/// Kind of loss.
enum Loss<'a> {
    Square,
    /// Tukey's biweight with a scale for each group.
    Biweight(&'a [f64]),
}

impl Loss<'_> {
    /// Loss of a squared residual, and the weight of its square in the normal equations.
    fn of(&self, squared: Option<f64>, group: usize) -> (f64, f64) {
        match (self, squared) {
            (Self::Square, Some(squared)) => (0.5 * squared, 1.0),
            (Self::Square, None) => (f64::MAX.sqrt(), 0.0),
            (Self::Biweight(scales), squared) => {
                let scale = scales[group];
                let part = squared.map_or(1.0, |squared| (squared / (CUT * scale).powi(2)).min(1.0));
                let rest = 1.0 - part;
                (CUT * CUT / 6.0 * (1.0 - rest * rest * rest), rest * rest / (scale * scale))
            }
        }
    }
}

/// Parameters with the least sum of squared residuals, reached from `start`.
pub fn squares<M: Model>(model: &M, start: Vec<f64>) -> Vec<f64> {
    minimise(model, start, &Loss::Square, LAST_STEPS)
}

/// Robust fit, reached from `start`.
pub fn robust<M: Model>(model: &M, start: Vec<f64>) -> Fit {
    rounds(model, start, ROUNDS)
}

/// A less exact robust fit in a shorter time, to compare starts.
pub fn roughly<M: Model>(model: &M, start: Vec<f64>) -> Fit {
    rounds(model, start, 3)
}

fn rounds<M: Model>(model: &M, start: Vec<f64>, rounds: usize) -> Fit {
    let mut parameters = start;
    // If the whole group determined the scale from the start, a set that is still far away would be left out as wrong.
    if model.sets() > 1 {
        (parameters, _) = with_scales(model, parameters, rounds, scales_of_sets);
    }
    let (mut parameters, scales) = with_scales(model, parameters, rounds, scales);
    parameters = minimise(model, parameters, &Loss::Biweight(&scales), LAST_STEPS);
    let residuals = residuals(model, &parameters);
    let loss = Loss::Biweight(&scales);
    let squared = |observation: usize| residuals[observation].map(DVec2::length_squared);
    let valued: Vec<(f64, f64)> =
        (0..residuals.len()).map(|index| loss.of(squared(index), model.group(index))).collect();
    let used: Vec<bool> = valued.iter().map(|(_, weight)| *weight > 0.0).collect();
    let breadth = |index: usize| 2.0 * scales[model.group(index)].ln();
    let cost = valued.iter().enumerate().map(|(index, (loss, _))| loss + breadth(index)).sum();
    let deviations = deviations(model, &residuals, &used);
    let covariance = information(model, &parameters, &used, &deviations).inverse();
    Fit { parameters, residuals, used, cost, deviations, covariance }
}

/// All residuals.
pub fn residuals<M: Model>(model: &M, parameters: &[f64]) -> Vec<Option<DVec2>> {
    let state = model.state(parameters);
    (0..model.observations()).map(|observation| model.residual(&state, observation)).collect()
}

/// Parameters and scales after some rounds, or as soon as the scales change no more.
fn with_scales<M: Model>(
    model: &M,
    start: Vec<f64>,
    rounds: usize,
    of: impl Fn(&M, &[Option<DVec2>]) -> Vec<f64>,
) -> (Vec<f64>, Vec<f64>) {
    let mut parameters = start;
    let mut scales = of(model, &residuals(model, &parameters));
    for _ in 0..rounds {
        parameters = minimise(model, parameters, &Loss::Biweight(&scales), STEPS);
        let next = of(model, &residuals(model, &parameters));
        // Scales only shrink, so that the rounds come to an end.
        let next: Vec<f64> = next.iter().zip(&scales).map(|(next, scale)| next.min(*scale)).collect();
        let settled = next.iter().zip(&scales).all(|(next, scale)| *next > 0.99 * scale);
        scales = next;
        if settled {
            break;
        }
    }
    (parameters, scales)
}

/// Scale of each group: that of the set which is farthest from its place.
fn scales_of_sets<M: Model>(model: &M, residuals: &[Option<DVec2>]) -> Vec<f64> {
    let mut lengths = vec![Vec::new(); model.groups() * model.sets()];
    for (observation, residual) in residuals.iter().enumerate() {
        let place = model.group(observation) * model.sets() + model.set(observation);
        lengths[place].push(residual.map_or(f64::INFINITY, DVec2::length));
    }
    let medians: Vec<f64> = lengths.iter_mut().map(|lengths| median(lengths)).collect();
    let greatest = |sets: &[f64]| sets.iter().copied().fold(0.0, f64::max);
    limited(medians.chunks_exact(model.sets()).map(greatest))
}

/// Scales from medians. No group has a smaller one than the first.
fn limited(medians: impl Iterator<Item = f64>) -> Vec<f64> {
    let scales: Vec<f64> = medians.map(|median| (median / MEDIAN_LENGTH).clamp(LEAST_SCALE, 1e9)).collect();
    scales.iter().map(|scale| scale.max(scales[0])).collect()
}

/// Scale of each group, from the median of its residuals.
fn scales<M: Model>(model: &M, residuals: &[Option<DVec2>]) -> Vec<f64> {
    let mut lengths = vec![Vec::new(); model.groups()];
    for (observation, residual) in residuals.iter().enumerate() {
        lengths[model.group(observation)].push(residual.map_or(f64::INFINITY, DVec2::length));
    }
    limited(lengths.iter_mut().map(|lengths| median(lengths)))
}

/// Median; 0 if there are no values.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Standard deviations of the coordinates of used residuals, for each group. The parameters reduce
/// the degrees of freedom of all groups by the same factor.
fn deviations<M: Model>(model: &M, residuals: &[Option<DVec2>], used: &[bool]) -> Vec<f64> {
    let mut sums = vec![(0.0, 0usize); model.groups()];
    for (observation, residual) in residuals.iter().enumerate().filter(|(observation, _)| used[*observation]) {
        let sum = &mut sums[model.group(observation)];
        sum.0 += residual.map_or(0.0, DVec2::length_squared);
        sum.1 += 2;
    }
    let all = sums.iter().map(|sum| sum.1).sum::<usize>().max(1) as f64;
    let solved = (0..model.parameters()).filter(|index| !model.is_held(*index)).count();
    let free = ((all - solved as f64) / all).max(1.0 / all);
    let deviation = |(sum, count): &(f64, usize)| (sum / (free * (*count).max(1) as f64)).sqrt().max(1e-12);
    let deviations: Vec<f64> = sums.iter().map(deviation).collect();
    deviations.iter().map(|deviation| deviation.max(deviations[0])).collect()
}

/// Fisher's information about the parameters in observations with these standard deviations of
/// their coordinates. Its inverse is the least covariance that any estimate can have (Cramér, Rao).
pub fn information<M: Model>(model: &M, parameters: &[f64], used: &[bool], deviations: &[f64]) -> Symmetric {
    let derivatives = Derivatives::at(model, parameters);
    let mut information = Symmetric::zero(model.parameters());
    for observation in (0..model.observations()).filter(|observation| used[*observation]) {
        let weight = deviations[model.group(observation)].powi(-2);
        derivatives.add_to(&mut information, observation, weight);
    }
    (0..model.parameters())
        .filter(|index| model.is_held(*index))
        .for_each(|index| information.add(index, index, KNOWN));
    information
}

/// Derivatives of all residuals.
struct Derivatives {
    /// The parameters of each observation, with the derivatives by them.
    rows: Vec<Vec<(usize, DVec2)>>,
}

impl Derivatives {
    fn at<M: Model>(model: &M, parameters: &[f64]) -> Self {
        let mut observers = vec![Vec::new(); model.parameters()];
        for observation in 0..model.observations() {
            model.depends(observation).for_each(|index| observers[index].push(observation));
        }
        let mut rows = vec![Vec::new(); model.observations()];
        let mut moved = parameters.to_vec();
        for (index, observers) in observers.into_iter().enumerate() {
            moved[index] = parameters[index] + STEP;
            let after = model.state(&moved);
            moved[index] = parameters[index] - STEP;
            let before = model.state(&moved);
            moved[index] = parameters[index];
            for observation in observers {
                let ends = (model.residual(&after, observation), model.residual(&before, observation));
                let slope = if let (Some(after), Some(before)) = ends { after - before } else { DVec2::ZERO };
                rows[observation].push((index, slope / (2.0 * STEP)));
            }
        }
        Self { rows }
    }

    fn add_to(&self, matrix: &mut Symmetric, observation: usize, weight: f64) {
        let row = &self.rows[observation];
        for (place, (i, by_i)) in row.iter().enumerate() {
            row[..=place].iter().for_each(|(j, by_j)| matrix.add(*i, *j, weight * by_i.dot(*by_j)));
        }
    }
}

fn minimise<M: Model>(model: &M, start: Vec<f64>, loss: &Loss, steps: usize) -> Vec<f64> {
    let squared = |residuals: &[Option<DVec2>], observation: usize| residuals[observation].map(DVec2::length_squared);
    let cost = |residuals: &[Option<DVec2>]| -> f64 {
        (0..residuals.len()).map(|index| loss.of(squared(residuals, index), model.group(index)).0).sum()
    };
    let mut parameters = start;
    let mut found = residuals(model, &parameters);
    let mut least = cost(&found);
    let mut damping = 1e-3;
    for _ in 0..steps {
        let derivatives = Derivatives::at(model, &parameters);
        let mut matrix = Symmetric::zero(model.parameters());
        let mut slope = vec![0.0; model.parameters()];
        for (observation, residual) in found.iter().enumerate() {
            let weight = loss.of(squared(&found, observation), model.group(observation)).1;
            let Some(residual) = residual.filter(|_| weight > 0.0) else { continue };
            derivatives.add_to(&mut matrix, observation, weight);
            for (index, by) in &derivatives.rows[observation] {
                slope[*index] -= weight * by.dot(residual);
            }
        }
        let Some((next, next_found, gain)) = (0..12).find_map(|_| {
            let step = damped(&matrix, damping).solve(&slope);
            let next = step.map(|step| parameters.iter().zip(step).map(|(p, s)| p + s).collect::<Vec<f64>>());
            let tried = next.map(|next| (residuals(model, &next), next));
            let better = tried.map(|(found, next)| (cost(&found), found, next)).filter(|(cost, ..)| *cost < least);
            damping = if better.is_some() { (damping * 0.1).max(1e-12) } else { damping * 8.0 };
            better.map(|(cost, found, next)| (next, found, least - cost))
        }) else {
            break;
        };
        let moved = parameters.iter().zip(&next).map(|(from, to)| (from - to).abs()).fold(0.0, f64::max);
        (parameters, found) = (next, next_found);
        least -= gain;
        if moved < 1e-13 || gain < 1e-12 * least {
            break;
        }
    }
    parameters
}

/// Returns the matrix with its diagonal enlarged. Parameters without influence stay where they are.
fn damped(matrix: &Symmetric, damping: f64) -> Symmetric {
    let mut damped = matrix.clone();
    for index in 0..matrix.size() {
        let own = matrix.at(index, index);
        damped.add(index, index, if own > 0.0 { damping * own } else { 1.0 });
    }
    damped
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two sets of points with a place of their own each, and a tenth of them wrong.
    struct Places {
        seen: Vec<DVec2>,
    }

    const EACH: usize = 200;

    impl Model for Places {
        type State = Vec<f64>;

        fn parameters(&self) -> usize {
            4
        }

        fn observations(&self) -> usize {
            self.seen.len()
        }

        fn state(&self, parameters: &[f64]) -> Self::State {
            parameters.to_vec()
        }

        fn residual(&self, places: &Self::State, observation: usize) -> Option<DVec2> {
            let set = self.set(observation);
            Some(DVec2::new(places[2 * set], places[2 * set + 1]) - self.seen[observation])
        }

        fn depends(&self, observation: usize) -> impl Iterator<Item = usize> {
            let set = self.set(observation);
            2 * set..2 * set + 2
        }

        fn set(&self, observation: usize) -> usize {
            usize::from(observation >= 4 * EACH)
        }

        fn sets(&self) -> usize {
            2
        }
    }

    /// The small set is a hundred scales away when the large one fits.
    #[test]
    fn a_set_that_is_far_away_is_found() {
        let mut random = crate::testing::random::Random::new(91);
        let places = [DVec2::new(0.001, 0.0), DVec2::new(1.0, -1.0)];
        let of_set = |set: usize| if set == 0 { 4 * EACH } else { EACH };
        let mut seen = Vec::new();
        for (set, place) in places.iter().enumerate() {
            for index in 0..of_set(set) {
                let error = if index % 10 == 9 { 50.0 * random.gaussian() } else { 0.01 * random.gaussian() };
                seen.push(*place + error);
            }
        }
        let model = Places { seen };
        let fit = robust(&model, vec![0.0; 4]);
        let found = DVec2::new(fit.parameters[2], fit.parameters[3]);
        assert!(found.distance(places[1]) < 0.005, "{found}");
        assert_eq!(fit.used.iter().filter(|used| **used).count(), 5 * EACH * 9 / 10);
    }
}
