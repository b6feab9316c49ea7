//! Widths of the pixels of measured calibrations.
//!
//! A pixel has almost no width if two measured values differ only by noise. No view needs such a
//! resolution, so pixels that are far narrower than nearly all others count as wider. A pixel that
//! is narrower than its neighbours counts as wide as these: around a pixel with a wrong value, the
//! directions run to a far place and back, and the pixels there have any shape.

use super::sample::outer;
use glam::{DMat3, DVec2, DVec3};

/// Number of places in each direction where widths are measured.
const PLACES: u32 = 32;
/// Part of the pixels that may be narrower than the usual width.
const FEW: f64 = 0.02;
/// Least width that counts, as a part of the usual width.
const NARROWEST: f64 = 0.7;

/// Distance of the neighbours with which a pixel is compared, pixels. A wrong value reaches one
/// pixel far, and the differences half a pixel more: at most one of the five places is near it.
const APART: f64 = 3.0;
/// Squared width of a pixel, as a part of its neighbours', from which on it is not compared. Where
/// the widths change smoothly, one of two opposite neighbours is always nearly as narrow.
const ALIKE: f64 = 0.9;

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

/// Returns the least squared width that counts for a pixel of a width of its own: `least`, or more
/// if it is narrower than most of its neighbours. `width` gives the squared width at a distance.
pub(super) fn least_beside(own: f64, least: f64, width: impl Fn(DVec2) -> Option<f64>) -> f64 {
    let usual = least / (NARROWEST * NARROWEST);
    if own >= usual {
        return least;
    }
    let beside = [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y].map(|side| width(side * APART));
    let mut widths: Vec<f64> = beside.into_iter().flatten().collect();
    widths.sort_by(f64::total_cmp);
    // The narrowest may be the one that is wrong.
    match widths.get(1) {
        Some(&other) if own < ALIKE * other => least.max(other.min(usual)),
        _ => least,
    }
}

/// Returns the part of a spread across the direction. Differences between directions that are far
/// apart also have a part along it, which is no width.
pub(super) fn across(direction: DVec3, spread: DMat3) -> DMat3 {
    let across = DMat3::IDENTITY - outer(direction, direction);
    across * spread * across
}

/// Returns the spread of a pixel in a direction, made wide enough.
pub(super) fn widened(direction: DVec3, spread: DMat3, least: f64) -> DMat3 {
    let missing = least - squared_width(&spread);
    if missing.is_nan() || missing <= 0.0 {
        return spread;
    }
    spread + (DMat3::IDENTITY - outer(direction, direction)) * missing
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

    /// A map as fine as the output, in which single pixels point far away. They may need up to the
    /// least width that counts, as a part of the usual one, in both directions: twice the texels.
    #[test]
    fn pixels_that_point_elsewhere_do_not_decide_on_the_resolution() {
        let (width, height) = (320, 240);
        let planned = |faulty: &[usize]| {
            let value = |index: usize| {
                let (x, y) = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
                let far = index as f32 % 7.0 / 7.0 - 0.5;
                match faulty.contains(&index) {
                    true => [far, 0.4 - far * far, -1.0],
                    false => [0.577 * (x / 160.0 - 1.0), 0.433 * (1.0 - y / 120.0), -1.0],
                }
            };
            let values = (0..width * height).map(value).collect();
            let grid = Grid::Raster(Raster::new((width as u32, height as u32), values).expect("a raster"));
            let calibration = Calibration { file: PathBuf::new(), grid, values: CalibrationValues::Directions };
            let rig = rig(vec![output("p", OutputKind::Mesh(Arc::new(calibration)))]);
            let plan = crate::views::plan(&rig, &request(&[(320, 240)])).expect("a plan");
            let texels: u64 = plan.views.iter().map(|view| view.tile.area()).sum();
            texels as f64 / (320.0 * 240.0)
        };
        let sound = planned(&[]);
        for at in [(160, 120), (161, 77), (85, 120), (40, 201), (250, 35)] {
            let faulty = planned(&[at.1 * width + at.0]);
            println!("{at:?}: {faulty:.3} texels for each pixel, {sound:.3} without");
            assert!(faulty < 2.1 * sound, "{at:?}: {faulty} texels for each pixel, {sound} without the fault");
        }
        let many: Vec<usize> = (0..100).map(|index| (index * 7919 + 30 * width) % (width * height)).collect();
        let faulty = planned(&many);
        println!("100: {faulty:.3} texels for each pixel, {sound:.3} without");
        assert!(faulty < 3.0 * sound, "{faulty} texels for each pixel, {sound} without the faults");
    }

    #[test]
    fn a_part_along_the_direction_is_no_width() {
        let direction = DVec3::new(0.6, 0.0, -0.8);
        let along = outer(direction, direction) * 7.0;
        let spread = outer(DVec3::Y, DVec3::Y) * 4.0;
        assert!(squared_width(&(spread + along)) > 3.9);
        assert!(squared_width(&across(direction, spread + along)) < 1e-12);
        assert!(across(direction, spread).abs_diff_eq(spread, 1e-12));
    }

    #[test]
    fn one_narrow_place_among_five_counts_as_wide_as_the_others() {
        let least = NARROWEST * NARROWEST;
        let beside = |narrow: DVec2| move |side: DVec2| Some(if side.normalize() == narrow { 0.0 } else { 0.95 });
        assert_eq!(least_beside(0.1, least, beside(DVec2::X)), 0.95);
        assert_eq!(least_beside(0.9, least, beside(DVec2::X)), least, "as narrow as the others");
        assert_eq!(least_beside(1.1, least, |_| panic!("not compared")), least);
        assert_eq!(least_beside(0.1, least, |_| Some(9.0)), 1.0, "not more than usual");
        assert_eq!(least_beside(0.1, least, |side| (side.x > 0.0).then_some(0.9)), least, "nothing to compare with");
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
