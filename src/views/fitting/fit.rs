//! The opening and the resolution that a view with given axes needs.
//!
//! A view's picture coordinates are `u = x/−z`, `w = y/−z`. Around a sample, one output pixel is
//! the disc `M·Mᵀ` in `(u, w)`, with M the 2×2 derivative of `(u, w)` by the pixel. With `F =
//! diag(f_x, f_y)` texels per unit, no output pixel covers less than a texel in any direction iff
//! all singular values of `F·M` are at least 1, that is `F² ⪰ G` with `G = (M·Mᵀ)⁻¹`. For a ratio
//! `r = f_x²/f_y²` the least `f_y²` is the greatest eigenvalue of `diag(r^−½, 1)·G·diag(r^−½, 1)`
//! over all samples: in closed form, so that only r is searched.

use crate::geom::Frustum;
use crate::views::fitting::density::{Metrics, density, least_squared_up};
use crate::views::fitting::lanes::{LANES, greater, greatest, least, lesser};
use crate::views::sampling::sample::{Sample, mean_direction};
use crate::views::sampling::samples::Samples;
use glam::{DMat3, DVec2, DVec3, DVec4};

/// Factor on the resolution for places between samples, which may need more than the samples do. It
/// is twice what any map so far needs over a 64th of a picture.
const RESERVE: f64 = 1.0001;

/// Directions with a smaller cosine from the axis (83°) are not drawn in perspective: the tangent
/// is above 8.
pub(crate) const LEAST_COSINE: f64 = 0.12;

/// Texels by which the sampled part is widened to each side, so that a direction on the border of
/// two views belongs to at least one of them in 32-bit arithmetic too.
pub(crate) const WIDENING: f64 = 0.21875;

/// Opening and resolution that a view with given axes needs.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct Fit {
    /// The sampled part.
    pub extent: Frustum,
    /// Texels per unit of tangent, across and up.
    pub density: DVec2,
}

impl Fit {
    /// Returns the number of texels of the sampled part.
    pub fn texels(&self) -> f64 {
        self.extent.width() * self.extent.height() * self.density.x * self.density.y
    }
}

/// Samples that are fitted many times, in groups of four.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patch {
    /// Groups of four. The last group is filled up with its first sample.
    fours: Vec<Four>,
    middle: DVec3,
}

/// Four samples: their directions, and their spreads (symmetric: xx, yy, zz, xy, xz, yz).
#[derive(Clone, Copy, Debug)]
struct Four {
    direction: [DVec4; 3],
    spread: [DVec4; 6],
}

impl Four {
    fn of(samples: &[Sample]) -> Self {
        let lanes = |part: &dyn Fn(&Sample) -> f64| {
            DVec4::from_array(std::array::from_fn(|lane| part(samples.get(lane).unwrap_or(&samples[0]))))
        };
        // Column, row.
        let spread = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        Self {
            direction: std::array::from_fn(|axis| lanes(&|sample| sample.direction[axis])),
            spread: spread.map(|(column, row)| lanes(&|sample| sample.spread.col(column)[row])),
        }
    }
}

impl Patch {
    /// Returns a patch of samples.
    pub fn new(samples: &[Sample]) -> Self {
        Self { fours: samples.chunks(LANES).map(Four::of).collect(), middle: mean_direction(samples.iter()) }
    }

    /// Returns a patch of all samples of an output.
    pub fn of(samples: &Samples) -> Self {
        Self::new(&samples.iter().copied().collect::<Vec<_>>())
    }

    /// Returns the mean of the samples' directions, of unit length; straight ahead if there is
    /// none.
    pub fn middle(&self) -> DVec3 {
        self.middle
    }
}

/// Returns the opening and resolution that a view with axes `rotation` (viewer → view) needs to
/// show `samples` with `quality` texels per pixel; `None` if there are no samples, or one lies too
/// far from the axis for a perspective view.
///
/// `fine` searches the ratio of the two resolutions to 1e-4 instead of some per cent.
pub(crate) fn fit(rotation: DMat3, samples: &Patch, quality: f64, fine: bool) -> Option<Fit> {
    let axes = Axes::new(rotation);
    // Reading the directions twice costs less than metrics that are not needed.
    let nearest = samples.fours.iter().fold(DVec4::splat(f64::INFINITY), |found, four| lesser(found, axes.ahead(four)));
    if least(nearest) < LEAST_COSINE {
        return None;
    }
    let mut metrics = Vec::with_capacity(samples.fours.len());
    let (mut low, mut high) = ([DVec4::splat(f64::INFINITY); 2], [DVec4::splat(f64::NEG_INFINITY); 2]);
    for four in &samples.fours {
        let (at, metric) = axes.project(four);
        for axis in 0..2 {
            (low[axis], high[axis]) = (lesser(low[axis], at[axis]), greater(high[axis], at[axis]));
        }
        metrics.push(metric);
    }
    let ([left, bottom], [right, top]) = (low.map(least), high.map(greatest));
    let extent = Frustum { left, right, bottom, top };
    Some(Fit { extent, density: density(&metrics, fine)? * (quality * RESERVE) })
}

impl Fit {
    /// Raises the resolution for `others`, further samples that the view shows.
    pub fn raise(&mut self, rotation: DMat3, others: &[Sample], quality: f64) {
        let axes = Axes::new(rotation);
        let shown: Vec<Sample> = others.iter().filter(|sample| axes.shows(sample)).copied().collect();
        let metrics: Vec<Metrics> = shown.chunks(LANES).map(|four| axes.project(&Four::of(four)).1).collect();
        if let Some(needed) = density(&metrics, true) {
            self.density = self.density.max(needed * (quality * RESERVE));
        }
    }
}

/// Returns the texels per pixel around a sample, in the direction with the fewest, for a view with
/// axes `rotation` (viewer → view) and `density` texels per unit of tangent; `None` if the sample
/// is too far from its axis.
pub(crate) fn sharpness(rotation: DMat3, density: DVec2, sample: &Sample) -> Option<f64> {
    let axes = Axes::new(rotation);
    if !axes.shows(sample) {
        return None;
    }
    let (_, metric) = axes.project(&Four::of(std::slice::from_ref(sample)));
    let squared = density * density;
    let scaled = Metrics {
        across: metric.across / DVec4::splat(squared.x),
        mixed: metric.mixed / DVec4::splat(density.x * density.y),
        up: metric.up / DVec4::splat(squared.y),
    };
    Some(1.0 / least_squared_up(&[scaled], 0.0).sqrt())
}

/// Axes of a view: the rows of its rotation (viewer → view).
struct Axes {
    rows: [[DVec4; 3]; 3],
    rotation: DMat3,
}

impl Axes {
    fn new(rotation: DMat3) -> Self {
        let rows = rotation.transpose();
        let lanes = |row: DVec3| row.to_array().map(DVec4::splat);
        Self { rows: [lanes(rows.x_axis), lanes(rows.y_axis), lanes(rows.z_axis)], rotation }
    }

    /// True if a sample is near enough to the axis.
    fn shows(&self, sample: &Sample) -> bool {
        -(self.rotation * sample.direction).z >= LEAST_COSINE
    }

    /// Returns the cosines of the angles from the axis.
    #[inline(always)]
    fn ahead(&self, four: &Four) -> DVec4 {
        let [_, _, back] = &self.rows;
        -dot(back, &four.direction)
    }

    /// Returns the places of four samples in the view, and their metrics there.
    #[inline(always)]
    fn project(&self, four: &Four) -> ([DVec4; 2], Metrics) {
        let [right, above, back] = &self.rows;
        let nearness = DVec4::splat(-1.0) / dot(back, &four.direction);
        let [x, y] = [right, above].map(|row| dot(row, &four.direction) * nearness);
        // Rows of d(u, w)/d(direction), in viewer axes and without the factor `nearness`.
        let row =
            |row: &[DVec4; 3], at: DVec4| -> [DVec4; 3] { std::array::from_fn(|axis| row[axis] + back[axis] * at) };
        let (across, up) = (row(right, x), row(above, y));
        let [xx, yy, zz, xy, xz, yz] = four.spread;
        let spread = |v: &[DVec4; 3]| [dot(&[xx, xy, xz], v), dot(&[xy, yy, yz], v), dot(&[xz, yz, zz], v)];
        let (spread_across, spread_up) = (spread(&across), spread(&up));
        let scale = nearness * nearness;
        let (xx, xy, yy) =
            (dot(&across, &spread_across) * scale, dot(&across, &spread_up) * scale, dot(&up, &spread_up) * scale);
        // A pixel that is seen edge-on would need an infinite resolution; it gets a finite one.
        let least = greater(DVec4::splat(1e-6) * xx * yy, DVec4::splat(f64::MIN_POSITIVE));
        let determinant = greater(least, xx * yy - xy * xy);
        ([x, y], Metrics { across: yy / determinant, mixed: -xy / determinant, up: xx / determinant })
    }
}

/// Returns the scalar products.
#[inline(always)]
fn dot([a_x, a_y, a_z]: &[DVec4; 3], [b_x, b_y, b_z]: &[DVec4; 3]) -> DVec4 {
    a_x * b_x + a_y * b_y + a_z * b_z
}
