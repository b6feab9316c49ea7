//! Widths of the pixels of measured calibrations.
//!
//! A pixel has almost no width if two measured values differ only by noise. No view needs such a
//! resolution, so pixels that are far narrower than nearly all others count as wider.

use glam::{DMat3, DVec2, DVec3};

/// Number of places in each direction where widths are measured.
const PLACES: u32 = 32;
/// Part of the pixels that may be narrower than the usual width.
const FEW: f64 = 0.02;
/// Least width that counts, as a part of the usual width.
const NARROWEST: f64 = 0.7;

/// Returns the places over a picture of `size` pixels at which the widths for [`least`] are
/// measured.
pub(super) fn places((width, height): (u32, u32)) -> impl Iterator<Item = DVec2> {
    let size = DVec2::new(f64::from(width), f64::from(height));
    let place = |index: u32| (f64::from(index) + 0.5) / f64::from(PLACES);
    (0..PLACES * PLACES).map(move |i| DVec2::new(place(i % PLACES), place(i / PLACES)) * size)
}

/// Returns the least squared width that counts for a pixel, squared radians, from the widths of
/// many; 0 without any.
pub(super) fn least(squared_widths: impl Iterator<Item = f64>) -> f64 {
    let mut widths: Vec<f64> = squared_widths.collect();
    widths.sort_by(f64::total_cmp);
    let usual = widths.get((widths.len() as f64 * FEW) as usize).copied().unwrap_or_default();
    usual * NARROWEST * NARROWEST
}

/// Returns the spread of a pixel in a direction, made wide enough.
pub(super) fn widened(direction: DVec3, spread: DMat3, least: f64) -> DMat3 {
    let missing = least - squared_width(&spread);
    if missing.is_nan() || missing <= 0.0 {
        return spread;
    }
    let along = DMat3::from_cols(direction * direction.x, direction * direction.y, direction * direction.z);
    spread + (DMat3::IDENTITY - along) * missing
}

/// True if a spread is as narrow as those that [`widened`] has changed.
pub(super) fn is_narrowest(spread: &DMat3, least: f64) -> bool {
    squared_width(spread) <= least * (1.0 + 1e-6)
}

/// Returns the lesser of the two eigenvalues of a spread that are not 0.
pub(super) fn squared_width(spread: &DMat3) -> f64 {
    let [x, y, z] = [spread.x_axis, spread.y_axis, spread.z_axis];
    let trace = x.x + y.y + z.z;
    let product = (x.x * y.y - x.y * y.x) + (y.y * z.z - y.z * z.y) + (x.x * z.z - x.z * z.x);
    let root = (trace * trace - 4.0 * product).max(0.0).sqrt();
    if trace > 0.0 { 2.0 * product.max(0.0) / (trace + root) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{Grid, Raster};
    use crate::rig::{Calibration, CalibrationValues, OutputKind};
    use crate::views::tests::{output, request, rig};
    use std::path::PathBuf;
    use std::sync::Arc;

    /// Returns a calibration of a flat picture of 60° × 45°, in which some pixels differ from their
    /// neighbour only by noise.
    fn calibrated(faulty: &[usize]) -> crate::rig::Rig {
        let (width, height) = (64, 48);
        let value = |index: usize| {
            let (x, y) = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
            [0.577 * (x / 32.0 - 1.0), 0.433 * (1.0 - y / 24.0), -1.0]
        };
        let mut values: Vec<[f32; 3]> = (0..width * height).map(value).collect();
        for &index in faulty {
            let [x, y, z] = values[index - 1];
            values[index] = [x + 1e-6, y, z];
        }
        let raster = Raster::new((width as u32, height as u32), values).expect("a raster");
        let calibration =
            Calibration { file: PathBuf::new(), grid: Grid::Raster(raster), values: CalibrationValues::Directions };
        rig(vec![output("p", OutputKind::Mesh(Arc::new(calibration)))])
    }

    #[test]
    fn a_few_faulty_pixels_do_not_decide_on_the_resolution() {
        let planned = |faulty: &[usize]| {
            let plan = crate::views::plan(&calibrated(faulty), &request(&[(640, 480)])).expect("a plan");
            let texels: u64 = plan.views.iter().map(|view| view.tile.area()).sum();
            (texels as f64 / (640.0 * 480.0), plan.notes.iter().any(|note| note.contains("far narrower")))
        };
        let (sound, noted) = planned(&[]);
        assert!((1.0..2.5).contains(&sound) && !noted, "{sound}");
        let (faulty, noted) = planned(&[700, 1530, 2345]);
        assert!(noted && faulty < 8.0 * sound, "{faulty} texels for each pixel, {sound} without the faults");
    }

    #[test]
    fn widths_are_those_of_the_ellipse() {
        let direction = DVec3::NEG_Z;
        let spread = DMat3::from_diagonal(DVec3::new(9.0, 0.25, 0.0));
        assert!((squared_width(&spread) - 0.25).abs() < 1e-12);
        assert_eq!(widened(direction, spread, 0.2), spread);
        let wider = widened(direction, spread, 1.0);
        assert!((squared_width(&wider) - 1.0).abs() < 1e-12 && is_narrowest(&wider, 1.0));
        assert!(wider.z_axis.length() < 1e-12, "nothing along the direction itself");
        assert_eq!(squared_width(&DMat3::ZERO), 0.0);
    }
}
