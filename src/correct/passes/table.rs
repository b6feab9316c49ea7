//! Tables of an output's directions and weights, for each pixel or for some pixels.

use crate::digest::Digest;
use glam::{DMat3, DVec3};
use serde::{Serialize, Serializer};
use std::fmt;
use std::sync::Arc;

/// Direction and weight of one pixel of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TablePixel {
    /// Direction from the viewer, viewer axes, any length but 0.
    pub direction: DVec3,
    /// Weight in linear light, 0…1: product of all weights except masks.
    pub weight: f64,
    /// Light of the blacks of all outputs there, as a part of white, ≥ 0.
    pub dark: f64,
}

/// Directions and weights of an output.
#[derive(Clone, PartialEq)]
pub struct Table {
    pub(in crate::correct) size: (u32, u32),
    pub(in crate::correct) step: u32,
    pub(in crate::correct) entries: (u32, u32),
    pub(in crate::correct) axes: DMat3,
    pub(in crate::correct) texels: Vec<[f32; 4]>,
    pub(in crate::correct) weighted: bool,
    pub(in crate::correct) lit: Arc<Vec<bool>>,
    pub(in crate::correct) error: f64,
}

/// Prints a checksum over all bits of entries and pixels in their place.
impl fmt::Debug for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { size, step, entries, axes, weighted, error, .. } = self;
        let sum = format_args!("{:x}", self.sum());
        let mut table = f.debug_struct("Table");
        table.field("size", size).field("step", step).field("entries", entries).field("axes", axes);
        table.field("sum", &sum).field("weighted", weighted).field("error", error).finish()
    }
}

/// As [`Debug`](fmt::Debug): a checksum replaces entries and pixels.
impl Serialize for Table {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let Self { size, step, entries, axes, weighted, error, .. } = self;
        (size, step, entries, axes, self.sum(), weighted, error).serialize(to)
    }
}

impl Table {
    fn sum(&self) -> Digest {
        let texels = self.texels.iter().flatten().map(|part| f64::from(*part));
        // Parts of 32 pixels, as exact numbers.
        let bits = |part: &[bool]| part.iter().fold(0, |bits: u32, lit| bits << 1 | u32::from(*lit));
        texels.chain(self.lit.chunks(32).map(|part| f64::from(bits(part)))).collect()
    }

    /// Returns the number of entries across and down.
    pub fn entries(&self) -> (u32, u32) {
        self.entries
    }

    /// Returns the distance between entries in pixels. 1: each entry is that of a pixel's centre.
    /// Otherwise the first one is at the output's top left corner.
    pub fn step(&self) -> u32 {
        self.step
    }

    /// Returns the rotation from the table's axes to viewer axes.
    pub fn axes(&self) -> DMat3 {
        self.axes
    }

    /// Returns the direction in the table's axes and the weight of each entry, row by row from the
    /// top. A direction of (0, 0, 0) shows nothing. With a step of 1, the length of a direction is
    /// 1 plus the light of black there; otherwise it is at most 1.
    pub fn texels(&self) -> &[[f32; 4]] {
        &self.texels
    }

    /// Returns the greatest error at a pixel's centre, in pixels of the output; 0 for a table of
    /// all pixels.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// True if some weight is not 1.
    pub fn is_weighted(&self) -> bool {
        self.weighted
    }

    /// Returns the entry of the pixel at a place (0…1 from the left and from the top; clamped), or
    /// `None` if the pixel shows nothing. If entries are farther apart than pixels, returns the
    /// interpolation of the entries around the place.
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

    /// Interpolates between the four entries around a pixel position, as the shaders do.
    pub(in crate::correct) fn interpolated(&self, across: f64, down: f64) -> [f64; 4] {
        let at = |place: f64, entries: u32| {
            let place = place.max(0.0) / f64::from(self.step);
            let first = place.floor().min(f64::from(entries) - 2.0);
            (first as usize, place - first)
        };
        let ((column, x), (row, y)) = (at(across, self.entries.0), at(down, self.entries.1));
        let entry = |column: usize, row: usize| self.texels[row * self.entries.0 as usize + column].map(f64::from);
        let mix = |a: [f64; 4], b: [f64; 4], part: f64| std::array::from_fn(|i| a[i] * (1.0 - part) + b[i] * part);
        let row_at = |row: usize| -> [f64; 4] { mix(entry(column, row), entry(column + 1, row), x) };
        mix(row_at(row), row_at(row + 1), y)
    }

    /// Interpolates between entries at a place, given as parts of width and height.
    pub(in crate::correct) fn between(&self, across: f64, down: f64) -> TablePixel {
        let [x, y, z, weight] = self.interpolated(across * f64::from(self.size.0), down * f64::from(self.size.1));
        TablePixel { direction: self.axes * DVec3::new(x, y, z), weight, dark: 0.0 }
    }
}
