//! Difference of an output's captured picture from its prediction.

use super::prediction::{Color, Prediction};
use crate::terminal;
use cupola::blend::Picture;
use glam::DVec2;
use serde_json::json;

/// Difference that is still good, in 255ths.
pub const BOUND: f64 = 2.0;

/// Difference of one output.
#[derive(Default)]
pub struct Difference {
    /// Pixels that were compared.
    compared: u64,
    /// Those that show some of the content.
    lit: u64,
    /// Those whose difference is at most [`BOUND`].
    within: u64,
    /// Greatest difference, in 255ths, and its pixel.
    worst: (f64, [u32; 2]),
    /// Pixels at a rim, where rounding decides whether they are black.
    left_out: u64,
}

impl Difference {
    /// Compares every pixel of the picture of an output, on all processors.
    pub fn of(prediction: &Prediction<'_>, output: usize, shown: &Picture) -> Self {
        let (width, height) = (shown.width as usize, shown.height as usize);
        let mut expected: Vec<Option<Color>> = vec![None; width * height];
        let bar = terminal::progress(height as u64, "rows");
        let rows = height.div_ceil(std::thread::available_parallelism().map_or(1, usize::from));
        std::thread::scope(|scope| {
            for (part, band) in expected.chunks_mut(rows * width).enumerate() {
                let bar = &bar;
                scope.spawn(move || {
                    for (row, line) in band.chunks_mut(width).enumerate() {
                        for (column, color) in line.iter_mut().enumerate() {
                            *color = prediction.pixel(output, centre(column, part * rows + row));
                        }
                        bar.inc(1);
                    }
                });
            }
        });
        bar.finish_and_clear();
        let mut found = Self::default();
        let shows = |column: usize, row: usize| expected[row * width + column].is_some();
        for (column, row) in (0..height).flat_map(|row| (0..width).map(move |column| (column, row))) {
            let here = shows(column, row);
            let beside = [
                (column.saturating_sub(1), row),
                ((column + 1).min(width - 1), row),
                (column, row.saturating_sub(1)),
                (column, (row + 1).min(height - 1)),
            ];
            let at_rim = beside.into_iter().any(|(column, row)| shows(column, row) != here);
            if at_rim && prediction.is_rim(output, centre(column, row)) {
                found.left_out += 1;
                continue;
            }
            let index = row * width + column;
            let color = expected[index].unwrap_or_default();
            let seen = &shown.rgb[3 * index..3 * index + 3];
            let channels = seen.iter().zip(color).map(|(seen, expected)| (f64::from(*seen) - expected).abs());
            found.add(channels.fold(0.0, f64::max) * 255.0, [column as u32, row as u32]);
            found.lit += u64::from(color.iter().any(|value| *value > 0.5 / 255.0));
        }
        found
    }

    fn add(&mut self, difference: f64, pixel: [u32; 2]) {
        self.compared += 1;
        self.within += u64::from(difference <= BOUND);
        if difference > self.worst.0 {
            self.worst = (difference, pixel);
        }
    }

    /// True if every pixel is as predicted, and an eighth of them shows something.
    pub fn is_good(&self) -> bool {
        self.within == self.compared && 8 * self.lit > self.compared
    }

    /// A row of the table.
    pub fn line(&self, name: &str) -> String {
        let [x, y] = self.worst.1;
        format!(
            "{name:<16} {:>10} {:>10} {:>9.4} % {:>8.2} {:>12} {:>9}",
            self.compared,
            self.lit,
            self.share(),
            self.worst.0,
            format!("{x}, {y}"),
            self.left_out
        )
    }

    /// Head of the table.
    pub fn head() -> String {
        format!(
            "{:<16} {:>10} {:>10} {:>11} {:>8} {:>12} {:>9}",
            "output", "pixels", "lit", "within", "worst", "at", "left out"
        )
    }

    /// The row as JSON.
    pub fn json(&self, name: &str) -> serde_json::Value {
        json!({
            "output": name,
            "pixels": self.compared,
            "lit": self.lit,
            "within_percent": self.share(),
            "worst": self.worst.0,
            "worst_at": self.worst.1,
            "left_out": self.left_out,
        })
    }

    fn share(&self) -> f64 {
        100.0 * self.within as f64 / self.compared.max(1) as f64
    }
}

/// Centre of a pixel.
fn centre(column: usize, row: usize) -> DVec2 {
    DVec2::new(column as f64, row as f64) + 0.5
}
