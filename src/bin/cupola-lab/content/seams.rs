//! What an audience sees of overlaps: steps of brightness where projectors begin and end.
//!
//! The light of all captured pictures is added up on the dome as the viewer sees it, and compared
//! with the content picture there. A step is the change of this difference between two neighbouring
//! pixels. If the light of two projectors does not add up, steps along the border of an overlap
//! have one sign.

use super::prediction::Prediction;
use crate::failure::Failure;
use cupola::blend::{Picture, simulate};
use cupola::geom::{Fisheye, pose};
use cupola::rig::Rig;
use serde_json::json;
use std::f64::consts::{FRAC_PI_2, PI};

/// Mean step along a border that is not visible, in 255ths.
pub const BOUND: f64 = 0.5;
/// Pixels beside the rim of what is shown that do not count: their light is mixed with black.
const RIM: usize = 3;

/// Sums of values.
#[derive(Clone, Copy, Default)]
pub struct Sums {
    count: u64,
    sum: f64,
    squares: f64,
}

/// Steps and differences of what an audience sees, in 255ths.
pub struct Seams {
    size: u32,
    /// Difference where one output shines, and where several do.
    zones: [Sums; 2],
    /// For each output, steps across its borders.
    borders: Vec<Sums>,
    /// Steps between pixels that the same outputs light.
    elsewhere: Sums,
}

impl Seams {
    /// Compares the sum of the captured pictures with the content, for the viewer of `rig`.
    pub fn of(rig: &Rig, prediction: &Prediction<'_>, captures: &[Picture], size: u32) -> Result<Self, Failure> {
        let simulation = simulate(rig, captures, size)?;
        let lens = Fisheye { aperture: rig.dome.coverage.max(PI) };
        let axes = pose::rotation(0.0, FRAC_PI_2 - rig.dome.tilt, 0.0);
        let (viewer, screen, side) = (rig.viewer_pose(), rig.surface(), size as usize);
        // Difference and lighting outputs of a pixel.
        let seen = |index: usize| {
            let place = |i: usize| (i as f64 + 0.5) / f64::from(size) * 2.0 - 1.0;
            let direction = axes * lens.direction(place(index % side), -place(index / side))?;
            let point = screen.unbounded_hit(viewer.position, viewer.direction_to_parent(direction))?.point;
            let expected: f64 = prediction.color(0, point)?.iter().sum();
            let found: f64 = simulation.rgb[3 * index..3 * index + 3].iter().map(|value| f64::from(*value)).sum();
            let lit = |map: &cupola::warp::WarpMap| map.pixel(point).is_some();
            let outputs =
                prediction.maps.iter().enumerate().fold(0u64, |bits, (i, map)| bits | u64::from(lit(map)) << i);
            (outputs != 0).then_some(((found - expected) * 85.0, outputs))
        };
        let pixels: Vec<Option<(f64, u64)>> = (0..side * side).map(seen).collect();
        let whole = |index: &usize| {
            let (x, y) = (index % side, index / side);
            let inner = |i: usize| i >= RIM && i + RIM < side;
            let around = |i: usize| i - RIM..=i + RIM;
            inner(x) && inner(y) && around(y).all(|y| around(x).all(|x| pixels[y * side + x].is_some()))
        };
        let empty = Sums::default();
        let mut found = Self { size, zones: [empty; 2], borders: vec![empty; captures.len()], elsewhere: empty };
        for index in (0..side * side).filter(whole) {
            let Some((here, outputs)) = pixels[index] else { continue };
            found.zones[usize::from(outputs.count_ones() > 1)].add(here);
            for (there, others) in [pixels[index + 1], pixels[index + side]].into_iter().flatten() {
                let crossed = outputs ^ others;
                match crossed.count_ones() {
                    0 => found.elsewhere.add(there - here),
                    // Inside minus outside.
                    1 if outputs & crossed != 0 => found.borders[crossed.trailing_zeros() as usize].add(here - there),
                    1 => found.borders[crossed.trailing_zeros() as usize].add(there - here),
                    _ => {}
                }
            }
        }
        Ok(found)
    }

    /// Greatest mean step across an output's borders, without its sign.
    fn greatest(&self) -> f64 {
        self.borders.iter().map(|border| border.mean().abs()).fold(0.0, f64::max)
    }

    /// True if no border is visible.
    pub fn is_good(&self) -> bool {
        self.greatest() <= BOUND
    }

    /// The results as lines.
    pub fn lines(&self, names: &[&str]) -> String {
        let words = |sums: &Sums| format!("{:>9} pixels, mean {:+.3}, rms {:.3}", sums.count, sums.mean(), sums.rms());
        let mut text = format!("as the audience sees it, {0} × {0} pixels, difference in 255ths:\n", self.size);
        text += &format!("{:<30}{}\n", "lit by one output", words(&self.zones[0]));
        if self.zones[1].count == 0 {
            return text;
        }
        text += &format!("{:<30}{}\n", "lit by several", words(&self.zones[1]));
        text += &format!("{:<30}{}\n", "steps between neighbours", words(&self.elsewhere));
        for (name, border) in names.iter().zip(&self.borders) {
            text += &format!("{:<30}{}\n", format!("steps at the border of {name}"), words(border));
        }
        text
    }

    /// The results as JSON.
    pub fn json(&self, names: &[&str]) -> serde_json::Value {
        let borders = names.iter().zip(&self.borders).map(|(name, border)| {
            let mut row = border.json();
            row["output"] = json!(name);
            row
        });
        json!({
            "size": self.size,
            "one_output": self.zones[0].json(),
            "several_outputs": self.zones[1].json(),
            "steps_elsewhere": self.elsewhere.json(),
            "steps_at_borders": borders.collect::<Vec<_>>(),
            "greatest_mean_step": self.greatest(),
        })
    }
}

impl Sums {
    fn add(&mut self, value: f64) {
        self.count += 1;
        self.sum += value;
        self.squares += value * value;
    }

    fn mean(&self) -> f64 {
        self.sum / self.count.max(1) as f64
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }

    fn json(&self) -> serde_json::Value {
        json!({ "pixels": self.count, "mean": self.mean(), "rms": self.rms() })
    }
}
