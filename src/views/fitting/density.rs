//! The least resolutions across and up that satisfy many metrics at once: the solution of
//! [`crate::views::fitting::fit`]'s problem.

use crate::views::fitting::lanes::{LANES, greater, greatest, least, lesser};
use glam::{DVec2, DVec4};

/// The metrics `G` of samples: squared pixels per unit of tangent, `[[across, mixed], [mixed,
/// up]]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::views) struct Metrics {
    pub across: DVec4,
    pub mixed: DVec4,
    pub up: DVec4,
}

/// One metric.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Metric {
    across: f64,
    mixed: f64,
    up: f64,
}

impl Metrics {
    /// Returns the metric of a lane.
    fn get(&self, lane: usize) -> Metric {
        Metric { across: self.across[lane], mixed: self.mixed[lane], up: self.up[lane] }
    }

    /// Makes it from up to four metrics; missing ones equal the first.
    fn of(metrics: &[Metric]) -> Self {
        let lanes = |part: fn(&Metric) -> f64| {
            DVec4::from_array(std::array::from_fn(|lane| part(metrics.get(lane).unwrap_or(&metrics[0]))))
        };
        Self { across: lanes(|m| m.across), mixed: lanes(|m| m.mixed), up: lanes(|m| m.up) }
    }
}

/// Returns the resolutions with the least product, in texels per unit of tangent at quality 1, that
/// satisfy all `metrics`; `None` if there are no metrics, or if no finite resolutions satisfy them.
///
/// `fine` searches the ratio of the two to 1e-4 instead of some per cent.
pub(in crate::views) fn density(metrics: &[Metrics], fine: bool) -> Option<DVec2> {
    let (mut across, mut up) = (DVec4::splat(0.0), DVec4::splat(0.0));
    for four in metrics {
        (across, up) = (greater(across, four.across), greater(up, four.up));
    }
    let (across, up) = (greatest(across), greatest(up));
    if !(across > 0.0 && up > 0.0 && across.is_finite() && up.is_finite()) {
        return None;
    }
    let metrics = &undominated(metrics);
    let centre = (across / up).ln();
    // Half the logarithm of the squared product.
    let cost = |log_ratio: f64| least_squared_up(metrics, log_ratio).ln() + 0.5 * log_ratio;
    let steps = if fine { 24 } else { 8 };
    let step = 6.0 / f64::from(steps);
    let start = centre - 3.0 + step * f64::from(valley(steps, |index| cost(centre - 3.0 + step * f64::from(index))));
    let log_ratio = golden_section(cost, start - step, start + step, if fine { 1e-4 } else { 6e-2 });
    let squared = least_squared_up(metrics, log_ratio);
    Some(DVec2::new((squared * log_ratio.exp()).sqrt(), squared.sqrt()))
}

/// Returns the minimum of a convex `cost` among 0…`last`, the first of equals. The search starts in
/// the middle and goes downhill.
///
/// The cost in [`density`] is convex. If the entries of a matrix have convex logarithms, its
/// greatest eigenvalue has one, too (Kingman 1961), and so has the greatest of many such
/// eigenvalues.
fn valley(last: u32, cost: impl Fn(u32) -> f64) -> u32 {
    let mut at = last / 2;
    let mut here = cost(at);
    let start = at;
    while at < last {
        let next = cost(at + 1);
        if next >= here {
            break;
        }
        (at, here) = (at + 1, next);
    }
    if at > start {
        return at;
    }
    while at > 0 {
        let next = cost(at - 1);
        if next > here {
            break;
        }
        (at, here) = (at - 1, next);
    }
    at
}

/// Returns the metrics without those that one of the few greatest metrics implies (`G ⪯ G'`).
fn undominated(metrics: &[Metrics]) -> Vec<Metrics> {
    let sizes: [fn(&Metrics) -> DVec4; 4] = [|m| m.across, |m| m.up, |m| m.across + m.up, |m| m.across * m.up];
    let pivots: Vec<Metric> = sizes.iter().filter_map(|size| metric_of_greatest(metrics, size)).collect();
    let all = |part: fn(&Metric) -> f64| -> Vec<DVec4> { pivots.iter().map(part).map(DVec4::splat).collect() };
    let (across, mixed, up) = (all(|m| m.across), all(|m| m.mixed), all(|m| m.up));
    let mut kept = pivots.clone();
    for four in metrics {
        // Above 0 where a pivot implies a metric: its excess has a positive determinant and
        // element, and so no negative eigenvalue.
        let mut implied = DVec4::splat(f64::NEG_INFINITY);
        for ((across, mixed), up) in across.iter().zip(&mixed).zip(&up) {
            let (across, mixed, up) = (*across - four.across, *mixed - four.mixed, *up - four.up);
            implied = greater(implied, lesser(across * up - mixed * mixed, across));
        }
        if least(implied) <= 0.0 {
            kept.extend((0..LANES).filter(|&lane| implied[lane] <= 0.0).map(|lane| four.get(lane)));
        }
    }
    kept.chunks(LANES).map(Metrics::of).collect()
}

/// Returns the metric of the greatest size.
fn metric_of_greatest(metrics: &[Metrics], size: impl Fn(&Metrics) -> DVec4) -> Option<Metric> {
    let mut sizes = DVec4::splat(f64::NEG_INFINITY);
    for four in metrics {
        sizes = greater(sizes, size(four));
    }
    let greatest = greatest(sizes);
    metrics.iter().rev().find_map(|four| {
        let sizes = size(four);
        (0..LANES).rev().find(|&lane| sizes[lane] == greatest).map(|lane| four.get(lane))
    })
}

/// Returns the least `f_y²` for `f_x²/f_y² = exp(log_ratio)`.
pub(in crate::views) fn least_squared_up(metrics: &[Metrics], log_ratio: f64) -> f64 {
    let (inverse, root) = (DVec4::splat((-log_ratio).exp()), DVec4::splat((-0.5 * log_ratio).exp()));
    let half = DVec4::splat(0.5);
    let mut eigenvalues = DVec4::splat(0.0);
    for four in metrics {
        let (across, mixed) = (four.across * inverse, four.mixed * root);
        let difference = half * (across - four.up);
        eigenvalues =
            greater(eigenvalues, half * (across + four.up) + (difference * difference + mixed * mixed).sqrt());
    }
    greatest(eigenvalues)
}

/// Returns the place of a minimum of `cost` between `low` and `high`, to `tolerance` (Kiefer 1953).
pub(crate) fn golden_section(cost: impl Fn(f64) -> f64, mut low: f64, mut high: f64, tolerance: f64) -> f64 {
    const PART: f64 = 0.618_033_988_749_894_8;
    let (mut left, mut right) = (high - PART * (high - low), low + PART * (high - low));
    let (mut at_left, mut at_right) = (cost(left), cost(right));
    while high - low > tolerance {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - PART * (high - low);
            at_left = cost(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + PART * (high - low);
            at_right = cost(right);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;

    /// Returns metrics of random ellipses, some of them long.
    fn metrics(random: &mut Random, count: usize) -> Vec<Metric> {
        let metric = |_| {
            let (long, short, turn) = (random.range(1.0, 30.0), random.range(0.01, 1.0), random.range(0.0, 3.2));
            let (sine, cosine) = turn.sin_cos();
            Metric {
                across: long * cosine * cosine + short * sine * sine,
                mixed: (long - short) * sine * cosine,
                up: long * sine * sine + short * cosine * cosine,
            }
        };
        (0..count).map(metric).collect()
    }

    /// Returns the greatest eigenvalue, computed one by one.
    fn greatest_eigenvalue(metrics: &[Metric], log_ratio: f64) -> f64 {
        metrics.iter().fold(0.0, |greatest, metric| {
            let (across, mixed) = (metric.across * (-log_ratio).exp(), metric.mixed * (-0.5 * log_ratio).exp());
            let half = 0.5 * (across - metric.up);
            f64::max(greatest, 0.5 * (across + metric.up) + (half * half + mixed * mixed).sqrt())
        })
    }

    /// Returns [`density`] over all metrics, with none left out and all steps tried.
    fn plain(metrics: &[Metric], fine: bool) -> DVec2 {
        let greatest = |part: fn(&Metric) -> f64| metrics.iter().map(part).fold(0.0, f64::max);
        let centre = (greatest(|m| m.across) / greatest(|m| m.up)).ln();
        let cost = |log_ratio: f64| greatest_eigenvalue(metrics, log_ratio).ln() + 0.5 * log_ratio;
        let steps = if fine { 24 } else { 8 };
        let step = 6.0 / f64::from(steps);
        let places = (0..=steps).map(|index| centre - 3.0 + step * f64::from(index));
        let start = places.min_by(|a, b| cost(*a).total_cmp(&cost(*b))).expect("some");
        let log_ratio = golden_section(cost, start - step, start + step, if fine { 1e-4 } else { 6e-2 });
        let squared = greatest_eigenvalue(metrics, log_ratio);
        DVec2::new((squared * log_ratio.exp()).sqrt(), squared.sqrt())
    }

    #[test]
    fn the_short_way_finds_what_all_metrics_and_all_steps_do() {
        let mut random = Random::new(5);
        for round in 0..400 {
            let metrics = metrics(&mut random, 1 + round % 90);
            let fours: Vec<Metrics> = metrics.chunks(LANES).map(Metrics::of).collect();
            for fine in [false, true] {
                let (short, plain) = (density(&fours, fine).expect("finite"), plain(&metrics, fine));
                assert!((short / plain - 1.0).abs().max_element() < 1e-12, "{short} for {plain}");
            }
            let log_ratio = random.range(-5.0, 5.0);
            assert_eq!(least_squared_up(&fours, log_ratio), greatest_eigenvalue(&metrics, log_ratio));
        }
    }

    #[test]
    fn what_is_found_satisfies_all_and_less_does_not() {
        let mut random = Random::new(6);
        for _ in 0..100 {
            let metrics = metrics(&mut random, 30);
            let fours: Vec<Metrics> = metrics.chunks(LANES).map(Metrics::of).collect();
            let found = density(&fours, true).expect("finite");
            // F² − G has no negative eigenvalue.
            let satisfied = |density: DVec2| {
                let squared = density * density;
                metrics.iter().all(|m| {
                    let (across, up) = (squared.x - m.across, squared.y - m.up);
                    across >= 0.0 && up >= 0.0 && across * up >= m.mixed * m.mixed
                })
            };
            assert!(satisfied(found * (1.0 + 1e-9)) && !satisfied(found * 0.999));
        }
    }

    #[test]
    fn a_valley_is_found_from_either_side_and_the_first_of_equals_counts() {
        for last in [1, 8, 24] {
            for bottom in 0..=2 * last {
                let cost = |index: u32| (f64::from(2 * index) - f64::from(bottom)).abs();
                let first = (0..=last).min_by(|a, b| cost(*a).total_cmp(&cost(*b)));
                assert_eq!(Some(valley(last, cost)), first, "{bottom} of {last}");
            }
        }
    }

    #[test]
    fn nothing_and_what_is_not_finite_have_no_density() {
        assert_eq!(density(&[], true), None);
        let metric = |across: f64, up: f64| Metrics::of(&[Metric { across, mixed: 0.0, up }]);
        for (across, up) in [(0.0, 1.0), (1.0, 0.0), (f64::INFINITY, 1.0), (f64::NAN, 1.0)] {
            assert_eq!(density(&[metric(across, up)], false), None, "{across} {up}");
        }
    }
}
