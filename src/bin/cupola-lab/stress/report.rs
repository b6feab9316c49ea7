//! Report of a stress run: the worst value of every quantity, its bound, and the seed of the case.

use serde_json::json;
use std::fmt::Write;

/// Greatest number of seeds that the text report lists for a bound that is exceeded.
const SEEDS_NAMED: usize = 32;

/// The value of one quantity in one case.
pub struct Finding {
    /// Name of the quantity, with its unit.
    pub quantity: &'static str,
    /// The worst value of the case.
    pub value: f64,
    /// The greatest allowed value.
    pub bound: f64,
    /// Number of compared pixels, vertices or matrices.
    pub compared: u64,
    /// True if these count towards `--pixels`.
    pub pixels: bool,
    /// Description of the case, or its rig file.
    pub input: String,
}

impl Finding {
    /// The finding for a valid rig that a later step refuses. This counts as an error.
    pub fn refusal(message: String) -> Self {
        Self { quantity: "valid rigs refused", value: 1.0, bound: 0.0, compared: 1, pixels: false, input: message }
    }
}

/// The worst value of a quantity over all cases.
struct Worst {
    quantity: &'static str,
    bound: f64,
    value: f64,
    compared: u64,
    seed: u64,
    input: String,
    /// Seeds of the cases that exceed the bound.
    failed: Vec<u64>,
}

/// Results of all cases so far.
pub struct Report {
    first_seed: u64,
    worst: Vec<Worst>,
    pixels: u64,
}

impl Report {
    /// An empty report.
    pub fn new(first_seed: u64) -> Self {
        Self { first_seed, worst: Vec::new(), pixels: 0 }
    }

    /// Number of pixels compared so far.
    pub fn compared(&self) -> u64 {
        self.pixels
    }

    /// True if any bound was exceeded.
    pub fn failed(&self) -> bool {
        self.worst.iter().any(|worst| !worst.failed.is_empty())
    }

    /// Adds the findings of the case `seed`.
    pub fn add(&mut self, seed: u64, findings: Vec<Finding>) {
        for found in findings {
            if found.pixels {
                self.pixels += found.compared;
            }
            let index = self.worst.iter().position(|worst| worst.quantity == found.quantity).unwrap_or_else(|| {
                self.worst.push(Worst {
                    quantity: found.quantity,
                    bound: found.bound,
                    value: f64::NEG_INFINITY,
                    compared: 0,
                    seed,
                    input: String::new(),
                    failed: Vec::new(),
                });
                self.worst.len() - 1
            });
            let worst = &mut self.worst[index];
            worst.compared += found.compared;
            // NaN counts as a failure and as the worst value.
            let within = found.value <= found.bound;
            if !within {
                worst.failed.push(seed);
            }
            let worse = found.value.is_nan() || found.value > worst.value;
            if worse && !worst.value.is_nan() {
                (worst.value, worst.seed, worst.input) = (found.value, seed, found.input);
            }
        }
    }

    /// The report as text.
    pub fn text(&self, cases: u64) -> String {
        let mut text = format!("{cases} cases from seed {}, {} pixels\n\n", self.first_seed, self.pixels);
        // Writing to a String cannot fail.
        _ = writeln!(
            text,
            "{:<66} {:>12} {:>11} {:>11}  {:<8} cases over it",
            "quantity", "compared", "worst", "bound", "seed"
        );
        for worst in &self.worst {
            _ = writeln!(
                text,
                "{:<66} {:>12} {:>11.3e} {:>11.3e}  {:<8} {}",
                worst.quantity,
                worst.compared,
                worst.value,
                worst.bound,
                worst.seed,
                worst.failed.len()
            );
        }
        for worst in self.worst.iter().filter(|worst| !worst.failed.is_empty()) {
            _ = write!(text, "\nOVER THE BOUND: {} (seed {})\n{}\n", worst.quantity, worst.seed, worst.input);
            let seeds: Vec<String> = worst.failed.iter().take(SEEDS_NAMED).map(u64::to_string).collect();
            let others = worst.failed.len() - seeds.len();
            let others =
                if others > 0 { format!(" and {others} more, all of them with --json") } else { String::new() };
            _ = writeln!(text, "seeds over it: {}{others}", seeds.join(", "));
        }
        text
    }

    /// The report as JSON.
    pub fn json(&self, cases: u64) -> serde_json::Value {
        let quantities: Vec<_> = self
            .worst
            .iter()
            .map(|worst| {
                json!({
                    "quantity": worst.quantity,
                    "compared": worst.compared,
                    "worst": worst.value,
                    "bound": worst.bound,
                    "seed": worst.seed,
                    "failed_seeds": worst.failed,
                    "input": worst.input,
                })
            })
            .collect();
        json!({
            "cases": cases,
            "first_seed": self.first_seed,
            "pixels": self.pixels,
            "failed": self.failed(),
            "quantities": quantities,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(value: f64) -> Finding {
        Finding { quantity: "error", value, bound: 1.0, compared: 10, pixels: true, input: format!("{value}") }
    }

    #[test]
    fn the_worst_case_is_kept_with_its_seed() {
        let mut report = Report::new(7);
        report.add(7, vec![finding(0.2)]);
        report.add(8, vec![finding(0.9)]);
        report.add(9, vec![finding(0.5)]);
        assert!(!report.failed());
        assert_eq!((report.worst[0].seed, report.worst[0].value, report.compared()), (8, 0.9, 30));
    }

    #[test]
    fn what_is_over_the_bound_and_what_is_not_a_number_fail() {
        for value in [1.1, f64::NAN, f64::INFINITY] {
            let mut report = Report::new(1);
            report.add(1, vec![finding(value)]);
            report.add(2, vec![finding(0.5)]);
            assert!(report.failed(), "{value}");
            assert_eq!(report.worst[0].seed, 1, "{value} stays the worst");
            assert!(report.text(2).contains("OVER THE BOUND"));
        }
    }

    #[test]
    fn the_seeds_of_all_failures_are_named() {
        let mut report = Report::new(1);
        for seed in 1..=40 {
            report.add(seed, vec![finding(if seed % 2 == 0 { 2.0 + seed as f64 } else { 0.5 })]);
        }
        assert!(report.text(40).contains("seeds over it: 2, 4, 6,"), "{}", report.text(40));
        assert!(!report.text(40).contains("more"), "{}", report.text(40));
        for seed in 41..=90 {
            report.add(seed, vec![finding(2.0)]);
        }
        assert!(report.text(90).contains("and 38 more"), "{}", report.text(90));
    }
}
