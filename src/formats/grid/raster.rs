//! A value for each pixel.

use super::Sample;
use crate::digest::Digest;
use glam::{DVec2, DVec3};
use serde::{Serialize, Serializer};
use std::fmt;

/// A value for each pixel of an output, or of a coarser or finer raster over it.
#[derive(Clone, PartialEq)]
pub struct Raster {
    size: (u32, u32),
    values: Vec<[f32; 3]>,
}

/// The text has a checksum of all bits of the values.
impl fmt::Debug for Raster {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sum = format_args!("{:x}", self.sum());
        f.debug_struct("Raster").field("size", &self.size).field("sum", &sum).finish()
    }
}

/// As in [`Debug`](fmt::Debug), a checksum replaces the numbers.
impl Serialize for Raster {
    fn serialize<S: Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        (self.size, self.sum()).serialize(to)
    }
}

impl Raster {
    fn sum(&self) -> Digest {
        self.values.iter().flatten().map(|value| f64::from(*value)).collect()
    }

    /// Makes a raster of `size` (width, height) from its values, row by row from the top. A pixel
    /// with a NaN shows nothing. `None` if the size is zero or not that of the values.
    pub fn new(size: (u32, u32), values: Vec<[f32; 3]>) -> Option<Self> {
        let fits = u64::from(size.0) * u64::from(size.1) == values.len() as u64 && !values.is_empty();
        fits.then_some(Self { size, values })
    }

    /// Width and height.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Values, row by row from the top.
    pub fn values(&self) -> &[[f32; 3]] {
        &self.values
    }

    /// Value at a place of the output, in parts of its width and height from the top left.
    ///
    /// It is linear between the centres of the raster's pixels, and continues linearly over the
    /// outer half of the outermost pixels. It is `None` where the nearest pixel shows nothing.
    /// Beside such pixels the others continue linearly where they have neighbours; otherwise the
    /// nearest pixel's value is used.
    pub fn sample(&self, part: DVec2) -> Option<Sample> {
        if !(part.cmpge(DVec2::ZERO).all() && part.cmple(DVec2::ONE).all()) {
            return None;
        }
        let (left, across) = cell(part.x, self.size.0);
        let (top, down) = cell(part.y, self.size.1);
        let at = |x: u32, y: u32| self.value(x.min(self.size.0 - 1), y.min(self.size.1 - 1));
        let corners = [at(left, top), at(left + 1, top), at(left, top + 1), at(left + 1, top + 1)];
        let value = match corners {
            [Some(a), Some(b), Some(c), Some(d)] => a.lerp(b, across).lerp(c.lerp(d, across), down),
            _ => self.beside_nothing([left, top], DVec2::new(across, down))?,
        };
        Some(Sample { value, intensity: 1.0 })
    }

    /// Value of a pixel, if it shows something.
    fn value(&self, x: u32, y: u32) -> Option<DVec3> {
        let value = self.values.get(y as usize * self.size.0 as usize + x as usize).filter(|_| x < self.size.0)?;
        let value = DVec3::from_array(value.map(f64::from));
        (!value.is_nan()).then_some(value)
    }

    /// Value at `part` of a cell with corners that show nothing: that of the nearest corner, with
    /// the slopes towards the pixels beside it that show something.
    fn beside_nothing(&self, [left, top]: [u32; 2], part: DVec2) -> Option<DVec3> {
        let step = [u32::from(part.x > 0.5 && self.size.0 > 1), u32::from(part.y > 0.5 && self.size.1 > 1)];
        let (x, y) = (left + step[0], top + step[1]);
        let nearest = self.value(x, y)?;
        let slope = |before: Option<DVec3>, after: Option<DVec3>| match (before, after) {
            (Some(before), Some(after)) => 0.5 * (after - before),
            (Some(before), None) => nearest - before,
            (None, Some(after)) => after - nearest,
            (None, None) => DVec3::ZERO,
        };
        let before = |place: u32| place.checked_sub(1);
        let across = slope(before(x).and_then(|x| self.value(x, y)), self.value(x + 1, y));
        let down = slope(before(y).and_then(|y| self.value(x, y)), self.value(x, y + 1));
        Some(nearest + across * (part.x - f64::from(step[0])) + down * (part.y - f64::from(step[1])))
    }
}

/// Number of the pixel (of `count`) whose centre is the last before `part` (0…1), and the distance
/// from there to `part`, in pixels: 0…1, and −½…1½ at the ends.
fn cell(part: f64, count: u32) -> (u32, f64) {
    let at = part * f64::from(count) - 0.5;
    let first = at.floor().clamp(0.0, f64::from(count.saturating_sub(2)));
    (first as u32, at - first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(raster: &Raster, x: f64, y: f64) -> Option<DVec3> {
        raster.sample(DVec2::new(x, y)).map(|sample| sample.value)
    }

    #[test]
    fn a_linear_raster_is_linear_to_its_rim() {
        let (width, height) = (7, 5);
        let value = |x: f64, y: f64| [3.0 * x - y, 1.0 + x + 10.0 * y, 4.0];
        let centre = |index: usize, count: u32| (index as f64 + 0.5) / f64::from(count);
        let values = (0..35).map(|i| value(centre(i % 7, width), centre(i / 7, height)).map(|v| v as f32)).collect();
        let raster = Raster::new((width, height), values).unwrap();
        for (x, y) in [(0.0, 0.0), (1.0, 1.0), (0.5, 0.5), (0.031, 0.97), (0.999, 0.001)] {
            let (found, expected) = (sample(&raster, x, y).unwrap(), DVec3::from_array(value(x, y)));
            assert!(found.distance(expected) < 1e-5, "({x}, {y}): {found} is not {expected}");
        }
        assert_eq!(sample(&raster, 1.001, 0.5), None);
        assert_eq!(sample(&raster, f64::NAN, 0.5), None);
    }

    #[test]
    fn what_shows_nothing_does_not_touch_its_neighbours() {
        let mut values = vec![[1.0, 2.0, 3.0]; 9];
        values[4] = [f32::NAN; 3];
        let raster = Raster::new((3, 3), values).unwrap();
        assert_eq!(sample(&raster, 0.5, 0.5), None);
        assert_eq!(sample(&raster, 0.32, 0.5), Some(DVec3::new(1.0, 2.0, 3.0)));
    }

    /// A constant value there would make a pixel without extent, which no resolution satisfies.
    #[test]
    fn a_linear_raster_is_linear_beside_what_shows_nothing() {
        let value = |x: f64, y: f64| [3.0 * x - y, 1.0 + x + 10.0 * y, 4.0];
        let mut values: Vec<_> =
            (0..35).map(|i| value(f64::from(i % 7) + 0.5, f64::from(i / 7) + 0.5).map(|v| v as f32)).collect();
        for hole in [0, 3, 10, 17, 24, 31, 28] {
            values[hole] = [f32::NAN; 3];
        }
        let raster = Raster::new((7, 5), values).unwrap();
        let mut shown = 0;
        for (x, y) in (0..50).flat_map(|y| (0..70).map(move |x| (f64::from(x) * 0.1 + 0.05, f64::from(y) * 0.1 + 0.05)))
        {
            let Some(found) = sample(&raster, x / 7.0, y / 5.0) else { continue };
            assert!(found.distance(DVec3::from_array(value(x, y))) < 1e-5, "({x}, {y}): {found}");
            shown += 1;
        }
        assert_eq!(shown, 2_800, "of the pixels that show something, every place");
    }

    #[test]
    fn a_single_pixel_is_everywhere() {
        let raster = Raster::new((1, 1), vec![[1.0, 2.0, 3.0]]).unwrap();
        assert_eq!(sample(&raster, 1.0, 0.0), Some(DVec3::new(1.0, 2.0, 3.0)));
        assert!(Raster::new((0, 1), Vec::new()).is_none() && Raster::new((2, 2), vec![[0.0; 3]; 3]).is_none());
    }
}
