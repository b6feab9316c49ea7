//! The opening and the resolution that a view with given axes needs.
//!
//! A view's picture coordinates are `u = x/−z`, `w = y/−z`. Around a sample, one output pixel is
//! the disc `M·Mᵀ` in `(u, w)`, with M the 2×2 derivative of `(u, w)` by the pixel. With `F = diag(f_x, f_y)`
//! texels per unit, no output pixel covers less than a texel in any direction iff all singular
//! values of `F·M` are at least 1, that is `F² ⪰ G` with `G = (M·Mᵀ)⁻¹`. For a ratio
//! `r = f_x²/f_y²` the least `f_y²` is the greatest eigenvalue of `diag(r^−½, 1)·G·diag(r^−½, 1)`
//! over all samples: in closed form, so that only r is searched.

use super::samples::Samples;
use super::sight::Sample;
use crate::geom::Frustum;
use glam::{DMat3, DVec2, DVec3};

/// The shortage of resolution between samples that is made good in advance.
const RESERVE: f64 = 1.001;

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

/// Gathers what falls into a view.
#[derive(Clone, Debug)]
pub(crate) struct Fitter {
    /// Viewer axes → view axes.
    rotation: DMat3,
    low: DVec2,
    high: DVec2,
    metrics: Vec<Metric>,
}

impl Fitter {
    /// An empty one for a view with axes `rotation` (viewer → view).
    pub fn new(rotation: DMat3) -> Self {
        let (low, high) = (DVec2::splat(f64::INFINITY), DVec2::splat(f64::NEG_INFINITY));
        Self { rotation, low, high, metrics: Vec::new() }
    }

    /// Adds all of `samples`; false where one of them lies too far from the axis for a perspective view.
    pub fn add_all(&mut self, samples: &Samples) -> bool {
        samples.iter().all(|sample| {
            let local = self.rotation * sample.direction;
            let ahead = -local.z >= LEAST_COSINE;
            if ahead {
                self.add(sample.direction, &sample.spread, local);
            }
            ahead
        })
    }

    /// Adds the part of `samples` with `|u|, |w| ≤ limit`.
    pub fn add_within(&mut self, samples: &Samples, limit: f64) {
        for line in &samples.lines {
            if let [only] = line.as_slice() {
                self.add_segment(only, only, limit);
            }
            for pair in line.windows(2) {
                self.add_segment(&pair[0], &pair[1], limit);
            }
        }
    }

    /// Whether nothing has been added.
    pub fn is_empty(&self) -> bool {
        self.metrics.is_empty()
    }

    fn add_segment(&mut self, from: &Sample, to: &Sample, limit: f64) {
        let (a, b) = (self.rotation * from.direction, self.rotation * to.direction);
        let Some((start, end)) = clip(a, b, limit) else { return };
        for part in [start, end] {
            self.add(
                from.direction.lerp(to.direction, part),
                &(from.spread * (1.0 - part) + to.spread * part),
                a.lerp(b, part),
            );
        }
    }

    fn add(&mut self, direction: DVec3, spread: &DMat3, local: DVec3) {
        let nearness = -1.0 / local.z;
        let at = DVec2::new(local.x, local.y) * nearness;
        self.low = self.low.min(at);
        self.high = self.high.max(at);
        // Rows of d(u, w)/d(direction), in viewer axes and without the factor `nearness`.
        let rows = self.rotation.transpose();
        let across = rows.x_axis + rows.z_axis * at.x;
        let up = rows.y_axis + rows.z_axis * at.y;
        // `direction` is of unit length but for the cut of a chord, which is short by its square.
        let scale = nearness * nearness / direction.length_squared();
        let (spread_across, spread_up) = (*spread * across, *spread * up);
        let (xx, xy, yy) =
            (across.dot(spread_across) * scale, across.dot(spread_up) * scale, up.dot(spread_up) * scale);
        // A pixel that is seen edge-on would ask for endless resolution; it gets a finite amount.
        let determinant = (xx * yy - xy * xy).max(1e-6 * xx * yy).max(f64::MIN_POSITIVE);
        self.metrics.push(Metric { across: yy / determinant, mixed: -xy / determinant, up: xx / determinant });
    }

    /// The fit for `quality` texels per pixel; `None` if nothing was added. `fine` searches the
    /// ratio of the two resolutions to 1e-4 instead of some per cent.
    pub fn fit(&self, quality: f64, fine: bool) -> Option<Fit> {
        let across = self.metrics.iter().map(|metric| metric.across).fold(0.0, f64::max);
        let up = self.metrics.iter().map(|metric| metric.up).fold(0.0, f64::max);
        if !(across > 0.0 && up > 0.0 && across.is_finite() && up.is_finite()) {
            return None;
        }
        let centre = (across / up).ln();
        let squared_up = |log_ratio: f64| self.least_squared_up(log_ratio);
        // log of f_x·f_y, up to a constant factor of 2
        let cost = |log_ratio: f64| squared_up(log_ratio).ln() + 0.5 * log_ratio;
        let steps = if fine { 24 } else { 8 };
        let step = 6.0 / f64::from(steps);
        let start = (0..=steps)
            .map(|index| centre - 3.0 + step * f64::from(index))
            .map(|log_ratio| (cost(log_ratio), log_ratio))
            .min_by(|a, b| a.0.total_cmp(&b.0))?
            .1;
        let log_ratio = golden_section(cost, start - step, start + step, if fine { 1e-4 } else { 3e-2 });
        let squared = squared_up(log_ratio);
        let scale = quality * RESERVE;
        let density = DVec2::new((squared * log_ratio.exp()).sqrt(), squared.sqrt()) * scale;
        let extent = Frustum { left: self.low.x, right: self.high.x, bottom: self.low.y, top: self.high.y };
        Some(Fit { extent, density })
    }

    /// The least `f_y²` for `f_x²/f_y² = exp(log_ratio)`.
    fn least_squared_up(&self, log_ratio: f64) -> f64 {
        let (inverse, root) = ((-log_ratio).exp(), (-0.5 * log_ratio).exp());
        self.metrics.iter().fold(0.0, |greatest, metric| {
            let (across, mixed) = (metric.across * inverse, metric.mixed * root);
            let half = 0.5 * (across - metric.up);
            f64::max(greatest, 0.5 * (across + metric.up) + (half * half + mixed * mixed).sqrt())
        })
    }
}

/// The part of the segment from `a` to `b` (view axes) with `|x|, |y| ≤ −limit·z`.
fn clip(a: DVec3, b: DVec3, limit: f64) -> Option<(f64, f64)> {
    let (mut start, mut end) = (0.0f64, 1.0f64);
    for plane in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y].map(|side| side + DVec3::NEG_Z * limit) {
        let (from, to) = (plane.dot(a), plane.dot(b));
        if from < 0.0 && to < 0.0 {
            return None;
        }
        if from < 0.0 {
            start = start.max(from / (from - to));
        } else if to < 0.0 {
            end = end.min(from / (from - to));
        }
    }
    // A segment through the apex of the pyramid cannot occur: neighbouring samples are close.
    (start <= end).then_some((start, end))
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
