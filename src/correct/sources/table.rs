//! Maps that have no closed form, and others on request: directions, weights and the light of
//! black, computed in f64.
//!
//! A table of all pixels contains the direction of each pixel's centre. So it is as exact as the
//! f64 map, up to one rounding to f32. The directions are stored in axes that look at the middle of
//! the picture. Rounding is then relative to the distance from that middle, and its effect in
//! pixels does not grow for a narrow opening. Error of the atlas coordinate, rounding and shader
//! together: at most 5e-7 of the view's width, a thousandth of a texel for a view 2000 texels wide.
//! Memory: 16 bytes per pixel. A coarser table has the requested error, and takes 16 bytes for each
//! entry and a byte for each pixel in memory.

use crate::correct::passes::table::{Table, TablePixel};
use crate::correct::single;
use crate::lock::Lock;
use crate::views::fitting::axes::facing;
use std::sync::{Arc, Mutex};

/// Interval of the pixels, in each direction, from which the middle of the picture is found.
const COARSE_STEP: usize = 16;
/// Rows that are computed at once.
const PART_ROWS: usize = 16;

impl Table {
    /// Returns the table of an output of `size` pixels. `at` returns the content of a pixel's
    /// centre, by column and row from the top left; `None` = nothing. It is called from several
    /// threads at once, and for some pixels twice.
    ///
    /// A direction that is zero or not finite shows nothing. Weights are clamped to 0…1, blacks to
    /// at least 0; NaN counts as 0. The light of black is stored as the excess of a direction's
    /// length over 1.
    pub fn new(size: (u32, u32), at: impl Fn(u32, u32) -> Option<TablePixel> + Sync) -> Self {
        let (columns, rows) = (size.0 as usize, size.1 as usize);
        let unit = |column: u32, row: u32| {
            let pixel = at(column, row)?;
            let scaled = pixel.direction / pixel.direction.abs().max_element();
            // `max` first: it turns NaN into 0.
            let (weight, dark) = (f64::max(pixel.weight, 0.0).min(1.0), f64::max(pixel.dark, 0.0));
            Some(TablePixel { direction: scaled.try_normalize()?, weight, dark })
        };
        let coarse = (0..rows).step_by(COARSE_STEP).flat_map(|row| {
            let pixel = &unit;
            (0..columns).step_by(COARSE_STEP).filter_map(move |column| pixel(column as u32, row as u32))
        });
        let axes = facing(coarse.map(|pixel| pixel.direction).sum());
        let to_axes = axes.transpose();
        let mut texels = vec![[0.0; 4]; columns * rows];
        let fill = |first_row: usize, part: &mut [[f32; 4]]| {
            for (row, line) in part.chunks_mut(columns.max(1)).enumerate() {
                for (column, texel) in line.iter_mut().enumerate() {
                    if let Some(pixel) = unit(column as u32, (first_row + row) as u32) {
                        *texel = single::texel(to_axes * pixel.direction * (1.0 + pixel.dark), pixel.weight);
                    }
                }
            }
        };
        in_parts(&mut texels, columns, rows, &fill);
        let lit: Vec<bool> = texels.iter().map(|texel| texel[..3] != [0.0; 3]).collect();
        let weighted = texels.iter().zip(&lit).any(|(texel, lit)| texel[3] != 1.0 && *lit);
        Self { size, step: 1, entries: size, axes, texels, weighted, lit: Arc::new(lit), error: 0.0 }
    }
}

/// Works on the rows of `lines` on all processors; `fill` gets the number of the first row of its
/// part.
pub(super) fn in_parts<T: Send>(
    lines: &mut [T],
    columns: usize,
    rows: usize,
    fill: &(impl Fn(usize, &mut [T]) + Sync),
) {
    let parts = Mutex::new(lines.chunks_mut((PART_ROWS * columns).max(1)).enumerate());
    // A function of its own, so that the lock is free while a part is filled.
    let next = || parts.locked().next();
    let work = || {
        while let Some((part, lines)) = next() {
            fill(part * PART_ROWS, lines);
        }
    };
    let helpers = std::thread::available_parallelism().map_or(1, usize::from).min(rows.div_ceil(PART_ROWS));
    std::thread::scope(|scope| {
        for _ in 1..helpers {
            // If a thread cannot be started, the others do its part.
            if std::thread::Builder::new().spawn_scoped(scope, work).is_err() {
                break;
            }
        }
        work();
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn what_is_degenerate_shows_nothing() {
        let bad = [DVec3::ZERO, DVec3::NAN, DVec3::new(f64::INFINITY, 0.0, 0.0)];
        let table = Table::new((4, 1), |column, _| {
            let direction = bad.get(column as usize).copied().unwrap_or(DVec3::X * 1e300);
            Some(TablePixel { direction, weight: f64::NAN, dark: f64::NAN })
        });
        for column in 0..3 {
            assert_eq!(table.at((f64::from(column) + 0.5) / 4.0, 0.5), None);
        }
        let last = table.at(0.9, 0.5).expect("shows something");
        assert!(last.direction.distance(DVec3::X) < 1e-7 && last.weight == 0.0, "{last:?}");
        assert!(Table::new((0, 0), |_, _| None).at(0.0, 0.0).is_none());
    }
}
