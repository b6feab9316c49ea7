//! Tables with fewer entries than pixels, between which shaders interpolate.

use crate::correct::passes::table::Table;
use crate::correct::single;
use crate::correct::sources::facets::WEIGHT_ERROR;
use crate::correct::sources::surface_sample::SurfaceSampler;
use crate::correct::sources::table::in_parts;
use crate::lock::Lock;
use glam::{DVec2, DVec3};
use std::sync::Mutex;

/// Distances between entries, in pixels: powers of two, so that the parts of a step are exact.
const STEPS: [u32; 7] = [128, 64, 32, 16, 8, 4, 2];

/// Returns the coarsest table of `sampler` whose error is at most `max_error` pixels and
/// [`WEIGHT_ERROR`] of the light, measured at the centre of every pixel. If no coarser table is
/// exact enough, returns that of all pixels.
///
/// The error of interpolation is proportional to the square of the step. Entries beyond a rim are
/// extrapolated from inside.
pub(in crate::correct) fn coarse(sampler: &SurfaceSampler, max_error: f64) -> Table {
    let exact = sampler.table();
    let finest = exact.finest_steps();
    let fits = |step| {
        let table = Table::with_step(sampler, &exact, step);
        let error = table.error_within(&exact, &finest, max_error)?;
        Some(Table { error, ..table })
    };
    STEPS.into_iter().find_map(fits).unwrap_or(exact)
}

impl Table {
    /// Returns the entries of `sampler`, `step` pixels apart, in the axes of `exact`.
    fn with_step(sampler: &SurfaceSampler, exact: &Self, step: u32) -> Self {
        let size = exact.size;
        let entries = (size.0.div_ceil(step) + 1, size.1.div_ceil(step) + 1);
        let to_axes = exact.axes.transpose();
        let at = |column: i64, row: i64| -> Option<[f64; 4]> {
            let sample = sampler.at(f64::from(step) * DVec2::new(column as f64, row as f64))?;
            let vector = to_axes * sample.vector;
            Some([vector.x, vector.y, vector.z, sample.weight])
        };
        let (columns, rows) = (i64::from(entries.0), i64::from(entries.1));
        let mut known: Vec<Option<[f64; 4]>> =
            (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))).map(|(c, r)| at(c, r)).collect();
        // Twice, for corners between two rims.
        for _ in 0..2 {
            known = continued(&known, columns, rows);
        }
        // Shaders use only directions, so the longest vector gets length 1.
        let longest =
            known.iter().flatten().map(|v| DVec3::new(v[0], v[1], v[2]).length()).fold(f64::MIN_POSITIVE, f64::max);
        let texels = known
            .iter()
            .map(|entry| entry.map_or([0.0; 4], |[x, y, z, w]| single::texel(DVec3::new(x, y, z) / longest, w)))
            .collect();
        Self {
            size,
            step,
            entries,
            texels,
            axes: exact.axes,
            weighted: exact.weighted,
            lit: exact.lit.clone(),
            error: 0.0,
        }
    }

    /// Returns the angle of each pixel, radians: root mean square of the steps to a neighbour
    /// across and to one down.
    fn finest_steps(&self) -> Vec<f64> {
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        let direction = |column: usize, row: usize| {
            let [x, y, z, _] = self.texels[row * width + column].map(f64::from);
            DVec3::new(x, y, z)
        };
        let step = |index: usize| {
            let (column, row) = (index % width, index / width);
            let own = direction(column, row);
            let to = |column: usize, row: usize| {
                let other = direction(column, row);
                (other != DVec3::ZERO).then(|| own.cross(other).length())
            };
            let across = (column + 1 < width).then(|| to(column + 1, row)).flatten();
            let across = across.or_else(|| to(column.checked_sub(1)?, row));
            let down = (row + 1 < height).then(|| to(column, row + 1)).flatten();
            let down = down.or_else(|| to(column, row.checked_sub(1)?));
            match (across, down) {
                (Some(across), Some(down)) => (0.5 * (across * across + down * down)).sqrt(),
                (Some(one), None) | (None, Some(one)) => one,
                (None, None) => 0.0,
            }
        };
        (0..width * height).map(step).collect()
    }

    /// Returns the error of this table against `exact` at the worst pixel's centre, in pixels,
    /// whose angles are `pixels`; `None` if it is more than `max_error`, or weights differ by more
    /// than [`WEIGHT_ERROR`].
    fn error_within(&self, exact: &Self, pixels: &[f64], max_error: f64) -> Option<f64> {
        let width = self.size.0 as usize;
        let mut worst = Mutex::new(Some(0.0f64));
        let row_error = |row: usize| {
            (0..width).try_fold(0.0f64, |worst, column| {
                let index = row * width + column;
                let [x, y, z, weight] = exact.texels[index].map(f64::from);
                let expected = DVec3::new(x, y, z);
                if expected == DVec3::ZERO {
                    return Some(worst);
                }
                let [x, y, z, found_weight] = self.interpolated(column as f64 + 0.5, row as f64 + 0.5);
                let found = DVec3::new(x, y, z);
                let angle = expected.cross(found).length().atan2(expected.dot(found));
                let good = angle <= max_error * pixels[index] && (weight - found_weight).abs() <= WEIGHT_ERROR;
                good.then(|| if angle > 0.0 { worst.max(angle / pixels[index]) } else { worst })
            })
        };
        let mut rows: Vec<usize> = (0..self.size.1 as usize).collect();
        in_parts(&mut rows, 1, self.size.1 as usize, &|_, part: &mut [usize]| {
            for &mut row in part {
                let failed = worst.locked().is_none();
                let error = if failed { return } else { row_error(row) };
                let mut worst = worst.locked();
                *worst = worst.zip(error).map(|(worst, error)| worst.max(error));
            }
        });
        *worst.unlocked_mut()
    }
}

/// Returns the entries. Missing entries next to known ones are extrapolated: by the mean of the
/// parabolas through the next three in a row, or of the lines through the next two.
fn continued(known: &[Option<[f64; 4]>], columns: i64, rows: i64) -> Vec<Option<[f64; 4]>> {
    let at = |column: i64, row: i64| {
        let inside = (0..columns).contains(&column) && (0..rows).contains(&row);
        if inside { known[(row * columns + column) as usize] } else { None }
    };
    let fill = |column: i64, row: i64| {
        let directions = (-1..=1).flat_map(|x| (-1..=1).map(move |y| (x, y))).filter(|&step| step != (0, 0));
        let mut best: Vec<[f64; 4]> = Vec::new();
        for points in [3, 2] {
            best.extend(directions.clone().filter_map(|(x, y)| {
                let next = |distance: i64| at(column + x * distance, row + y * distance);
                let (a, b) = (next(1)?, next(2)?);
                Some(match points {
                    3 => {
                        let c = next(3)?;
                        std::array::from_fn(|i| 3.0 * (a[i] - b[i]) + c[i])
                    }
                    _ => std::array::from_fn(|i| 2.0 * a[i] - b[i]),
                })
            }));
            if !best.is_empty() {
                break;
            }
        }
        let count = best.len() as f64;
        best.into_iter()
            .reduce(|sum, one| std::array::from_fn(|i| sum[i] + one[i]))
            .map(|sum| sum.map(|value| value / count))
    };
    (0..rows)
        .flat_map(|row| (0..columns).map(move |column| (column, row)))
        .map(|(column, row)| at(column, row).or_else(|| fill(column, row)))
        .collect()
}
