//! The opening and the resolution that a view with given axes needs.
//!
//! A view's picture coordinates are `u = x/−z`, `w = y/−z`. Around a sample, one output pixel is
//! the disc `M·Mᵀ` in `(u, w)`, with M the 2×2 derivative of `(u, w)` by the pixel. With `F = diag(f_x, f_y)`
//! texels per unit, no output pixel covers less than a texel in any direction iff all singular
//! values of `F·M` are at least 1, that is `F² ⪰ G` with `G = (M·Mᵀ)⁻¹`. For a ratio
//! `r = f_x²/f_y²` the least `f_y²` is the greatest eigenvalue of `diag(r^−½, 1)·G·diag(r^−½, 1)`
//! over all samples: in closed form, so that only r is searched.

use super::sight::Sample;
use crate::geom::Frustum;
use glam::{DMat3, DVec2};

/// The shortage of resolution between samples that is made good in advance: over a fortieth of a picture, twice what the
/// curvature of any map seen so far hides.
const RESERVE: f64 = 1.0003;

/// Directions with a smaller cosine from the axis (83°) are not drawn in perspective: the tangent is above 8.
pub(crate) const LEAST_COSINE: f64 = 0.12;

/// What a view with given axes needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fit {
    /// The sampled part.
    pub extent: Frustum,
    /// Texels per unit of tangent, across and up.
    pub density: DVec2,
}

impl Fit {
    /// Texels of the sampled part.
    pub fn texels(&self) -> f64 {
        self.extent.width() * self.extent.height() * self.density.x * self.density.y
    }
}

/// The metric `G` of a sample: squared pixels per unit of tangent, `[[across, mixed], [mixed, up]]`.
#[derive(Clone, Copy, Debug)]
struct Metric {
    across: f64,
    mixed: f64,
    up: f64,
}

/// What a view with axes `rotation` (viewer → view) needs to show `samples` with `quality` texels
/// per pixel; `None` if there are none, or one lies too far from the axis for a perspective view.
///
/// `fine` searches the ratio of the two resolutions to 1e-4 instead of some per cent.
pub(crate) fn fit(rotation: DMat3, samples: &[Sample], quality: f64, fine: bool) -> Option<Fit> {
    let mut metrics = Vec::with_capacity(samples.len());
    let (mut low, mut high) = (DVec2::splat(f64::INFINITY), DVec2::splat(f64::NEG_INFINITY));
    for sample in samples {
        let (at, metric) = project(rotation, sample)?;
        (low, high) = (low.min(at), high.max(at));
        metrics.push(metric);
    }
    let extent = Frustum { left: low.x, right: high.x, bottom: low.y, top: high.y };
    Some(Fit { extent, density: density(&metrics, fine)? * (quality * RESERVE) })
}

impl Fit {
    /// Raises the resolution to what `others`, shown by the same view, need too.
    pub fn raise(&mut self, rotation: DMat3, others: &[Sample], quality: f64) {
        let metrics: Vec<Metric> =
            others.iter().filter_map(|sample| project(rotation, sample)).map(|seen| seen.1).collect();
        if let Some(needed) = density(&metrics, true) {
            self.density = self.density.max(needed * (quality * RESERVE));
        }
    }
}

/// Texels per pixel around a sample in the direction in which there are fewest, in a view with axes `rotation`
/// (viewer → view) and `density` texels per unit of tangent; `None` too far from its axis.
pub(crate) fn sharpness(rotation: DMat3, density: DVec2, sample: &Sample) -> Option<f64> {
    let (_, metric) = project(rotation, sample)?;
    let squared = density * density;
    let scaled = Metric {
        across: metric.across / squared.x,
        mixed: metric.mixed / (density.x * density.y),
        up: metric.up / squared.y,
    };
    Some(1.0 / least_squared_up(&[scaled], 0.0).sqrt())
}

/// Where a sample lies in a view, and its metric there; `None` if it is too far from the axis.
fn project(rotation: DMat3, sample: &Sample) -> Option<(DVec2, Metric)> {
    let local = rotation * sample.direction;
    if -local.z < LEAST_COSINE {
        return None;
    }
    let nearness = -1.0 / local.z;
    let at = DVec2::new(local.x, local.y) * nearness;
    // Rows of d(u, w)/d(direction), in viewer axes and without the factor `nearness`.
    let rows = rotation.transpose();
    let (across, up) = (rows.x_axis + rows.z_axis * at.x, rows.y_axis + rows.z_axis * at.y);
    let (spread_across, spread_up) = (sample.spread * across, sample.spread * up);
    let scale = nearness * nearness;
    let (xx, xy, yy) = (across.dot(spread_across) * scale, across.dot(spread_up) * scale, up.dot(spread_up) * scale);
    // A pixel that is seen edge-on would ask for endless resolution; it gets a finite amount.
    let determinant = (xx * yy - xy * xy).max(1e-6 * xx * yy).max(f64::MIN_POSITIVE);
    Some((at, Metric { across: yy / determinant, mixed: -xy / determinant, up: xx / determinant }))
}

/// The least product of resolutions, in texels per unit of tangent at quality 1, that satisfies all `metrics`.
fn density(metrics: &[Metric], fine: bool) -> Option<DVec2> {
    let across = metrics.iter().map(|metric| metric.across).fold(0.0, f64::max);
    let up = metrics.iter().map(|metric| metric.up).fold(0.0, f64::max);
    if !(across > 0.0 && up > 0.0 && across.is_finite() && up.is_finite()) {
        return None;
    }
    let metrics = &undominated(metrics);
    let centre = (across / up).ln();
    // log of the squared product, halved
    let cost = |log_ratio: f64| least_squared_up(metrics, log_ratio).ln() + 0.5 * log_ratio;
    let steps = if fine { 24 } else { 8 };
    let step = 6.0 / f64::from(steps);
    let start = (0..=steps)
        .map(|index| centre - 3.0 + step * f64::from(index))
        .map(|log_ratio| (cost(log_ratio), log_ratio))
        .min_by(|a, b| a.0.total_cmp(&b.0))?
        .1;
    let log_ratio = golden_section(cost, start - step, start + step, if fine { 1e-4 } else { 6e-2 });
    let squared = least_squared_up(metrics, log_ratio);
    Some(DVec2::new((squared * log_ratio.exp()).sqrt(), squared.sqrt()))
}

/// The metrics but for those that others imply (`G ⪯ G'`), as far as the few greatest ones tell.
fn undominated(metrics: &[Metric]) -> Vec<Metric> {
    let greatest = |size: fn(&Metric) -> f64| metrics.iter().max_by(|a, b| size(a).total_cmp(&size(b)));
    let pivots: Vec<Metric> =
        [greatest(|m| m.across), greatest(|m| m.up), greatest(|m| m.across + m.up), greatest(|m| m.across * m.up)]
            .into_iter()
            .flatten()
            .copied()
            .collect();
    let implied = |metric: &Metric, by: &Metric| {
        let (across, mixed, up) = (by.across - metric.across, by.mixed - metric.mixed, by.up - metric.up);
        across >= 0.0 && up >= 0.0 && across * up > mixed * mixed
    };
    let rest = metrics.iter().filter(|metric| !pivots.iter().any(|pivot| implied(metric, pivot)));
    pivots.iter().chain(rest).copied().collect()
}

/// The least `f_y²` for `f_x²/f_y² = exp(log_ratio)`.
fn least_squared_up(metrics: &[Metric], log_ratio: f64) -> f64 {
    let (inverse, root) = ((-log_ratio).exp(), (-0.5 * log_ratio).exp());
    metrics.iter().fold(0.0, |greatest, metric| {
        let (across, mixed) = (metric.across * inverse, metric.mixed * root);
        let half = 0.5 * (across - metric.up);
        f64::max(greatest, 0.5 * (across + metric.up) + (half * half + mixed * mixed).sqrt())
    })
}

/// The place of a minimum of `cost` between `low` and `high`, to `tolerance` (Kiefer 1953).
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
