//! Maps that have no closed form, and others on request: directions, weights and the light of black, computed in f64.
//!
//! A table of all pixels holds what a pixel's centre shows, so it is as exact as the f64 map that it was made of, up to
//! one rounding to f32. The directions are kept in axes of their own that look at the middle of what is
//! shown: the rounding then is relative to the distance from that middle, and its effect in pixels does not grow
//! where the opening is narrow. Error of the atlas coordinate, rounding and shader together: at most
//! 5e-7 of the view's width, a thousandth of a texel for a view 2000 texels wide. Memory: 16 bytes per pixel. A coarser one is as exact as was asked for, and takes 16 bytes for each entry
//! and a byte for each pixel in memory.

pub(in crate::correct) use crate::correct::sources::table_cached::kept;
pub(in crate::correct) use crate::correct::sources::table_coarse::coarse;

use crate::correct::shaders::uniforms;
use crate::digest::Digest;
use crate::views::fitting::axes::facing;
use glam::{DMat3, DVec3};
use std::fmt;
use std::sync::{Arc, Mutex};

/// What one pixel of a table shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TablePixel {
    /// Direction from the viewer, viewer axes, any length but 0.
    pub direction: DVec3,
    /// Weight in linear light, 0…1: everything that is known beforehand, except masks.
    pub weight: f64,
    /// Light of the blacks of all outputs there, as a part of white, ≥ 0.
    pub dark: f64,
}

/// Directions and weights of an output.
#[derive(Clone, PartialEq)]
pub struct Table {
    pub(super) size: (u32, u32),
    pub(super) step: u32,
    pub(super) entries: (u32, u32),
    pub(super) axes: DMat3,
    pub(super) texels: Vec<[f32; 4]>,
    pub(super) weighted: bool,
    pub(super) lit: Arc<Vec<bool>>,
    pub(super) error: f64,
}

/// A sum stands for entries and pixels, all bits of them.
impl fmt::Debug for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { size, step, entries, axes, texels, weighted, lit, error } = self;
        let mut digest = Digest::default();
        for [x, y, z, weight] in texels {
            let pair = |low: &f32, high: &f32| u64::from(low.to_bits()) | u64::from(high.to_bits()) << 32;
            digest.add(pair(x, y));
            digest.add(pair(z, weight));
        }
        lit.chunks(64).for_each(|part| digest.add(part.iter().fold(0, |bits, lit| bits << 1 | u64::from(*lit))));
        let sum = format_args!("{digest:x}");
        let mut table = f.debug_struct("Table");
        table.field("size", size).field("step", step).field("entries", entries).field("axes", axes);
        table.field("sum", &sum).field("weighted", weighted).field("error", error).finish()
    }
}

/// Every so many pixels are looked at to find the middle of what is shown.
const COARSE_STEP: usize = 16;
/// Rows that are computed at once.
const PART_ROWS: usize = 16;

impl Table {
    /// The table of `at` (column and row from the top left → what the pixel's centre shows, `None` = nothing)
    /// for an output of `size` pixels. The function is called from several threads at once, and for some pixels twice.
    ///
    /// A direction that is zero or not finite shows nothing; weights are limited to 0…1, blacks to 0 at least, NaN counts
    /// as 0. The light of black is kept as what a direction's length is more than 1.
    pub fn new(size: (u32, u32), at: impl Fn(u32, u32) -> Option<TablePixel> + Sync) -> Self {
        let (columns, rows) = (size.0 as usize, size.1 as usize);
        let unit = |column: u32, row: u32| {
            let pixel = at(column, row)?;
            let scaled = pixel.direction / pixel.direction.abs().max_element();
            // `max` first: it takes NaN to 0.
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
                        *texel = uniforms::texel(to_axes * pixel.direction * (1.0 + pixel.dark), pixel.weight);
                    }
                }
            }
        };
        in_parts(&mut texels, columns, rows, &fill);
        let lit: Vec<bool> = texels.iter().map(|texel| texel[..3] != [0.0; 3]).collect();
        let weighted = texels.iter().zip(&lit).any(|(texel, lit)| texel[3] != 1.0 && *lit);
        Self { size, step: 1, entries: size, axes, texels, weighted, lit: Arc::new(lit), error: 0.0 }
    }

    /// Number of entries across and down.
    pub fn entries(&self) -> (u32, u32) {
        self.entries
    }

    /// How far apart entries are in pixels. 1: each is that of a pixel's centre. Otherwise the first one is at the
    /// output's top left corner.
    pub fn step(&self) -> u32 {
        self.step
    }

    /// The table's axes → viewer axes.
    pub fn axes(&self) -> DMat3 {
        self.axes
    }

    /// Direction in the table's axes, of length 1 or less, and weight of each entry, row by row from the top; a direction
    /// of (0, 0, 0) shows nothing.
    pub fn texels(&self) -> &[[f32; 4]] {
        &self.texels
    }

    /// The greatest error at a pixel's centre, in pixels of the output; 0 for a table of all pixels.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Some weight is not 1.
    pub fn is_weighted(&self) -> bool {
        self.weighted
    }

    /// What is shown at a place (0…1 from the left and from the top, limited to it): what the nearest pixel shows, or, if
    /// that shows anything and entries are farther apart, what lies between them.
    pub fn at(&self, across: f64, down: f64) -> Option<TablePixel> {
        let index = |part: f64, count: u32| ((part * f64::from(count)).max(0.0) as usize).min(count as usize - 1);
        if self.texels.is_empty() {
            return None;
        }
        let pixel = index(down, self.size.1) * self.size.0 as usize + index(across, self.size.0);
        if !self.lit[pixel] {
            return None;
        }
        if self.step > 1 {
            return Some(self.between(across, down));
        }
        let [x, y, z, weight] = self.texels[pixel];
        let local = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
        let dark = (local.length() - 1.0).max(0.0);
        Some(TablePixel { direction: self.axes * local, weight: f64::from(weight), dark })
    }
}

/// Works on the rows of `lines` on all processors; `fill` gets the number of the first row of its part.
pub(super) fn in_parts<T: Send>(
    lines: &mut [T],
    columns: usize,
    rows: usize,
    fill: &(impl Fn(usize, &mut [T]) + Sync),
) {
    let parts = Mutex::new(lines.chunks_mut((PART_ROWS * columns).max(1)).enumerate());
    let work = || {
        while let Some((part, lines)) = parts.lock().ok().and_then(|mut parts| parts.next()) {
            fill(part * PART_ROWS, lines);
        }
    };
    let helpers = std::thread::available_parallelism().map_or(1, usize::from).min(rows.div_ceil(PART_ROWS));
    std::thread::scope(|scope| {
        for _ in 1..helpers {
            // Where no thread can be had, the others do its part.
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
