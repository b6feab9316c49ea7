//! Numbers that a key of a rig file may have.

use crate::rig::reading::accepted_keys::Accepts;

/// Numbers that a key may have.
pub(in crate::rig) struct Allowed {
    /// Least value.
    pub(super) least: f64,
    /// Greatest value.
    greatest: f64,
    /// True for each end that is excluded: (least, greatest).
    open: (bool, bool),
    /// Description of the number, with its unit: "a radius in metres".
    pub(super) what: &'static str,
}

impl Allowed {
    /// From `least` to `greatest`, both included.
    pub(in crate::rig) const fn closed(least: f64, greatest: f64, what: &'static str) -> Self {
        Self { least, greatest, open: (false, false), what }
    }

    /// Greater than `least`, up to and including `greatest`.
    pub(in crate::rig) const fn above(least: f64, greatest: f64, what: &'static str) -> Self {
        Self { least, greatest, open: (true, false), what }
    }

    /// Between `least` and `greatest`, both excluded.
    pub(in crate::rig) const fn between(least: f64, greatest: f64, what: &'static str) -> Self {
        Self { least, greatest, open: (true, true), what }
    }

    /// From and including `least`, less than `greatest`.
    pub(in crate::rig) const fn below(least: f64, greatest: f64, what: &'static str) -> Self {
        Self { least, greatest, open: (false, true), what }
    }

    /// Record of a key with `count` of these numbers.
    pub(super) fn note(&self, count: Option<usize>) -> Accepts {
        Accepts::Number { count, least: self.least, greatest: self.greatest, what: self.what }
    }

    /// Returns the reason why `value` is not allowed; `None` if it is allowed.
    pub(in crate::rig) fn refuse(&self, value: f64) -> Option<String> {
        if !value.is_finite() {
            return Some(format!("{value} is no number that can be used; expected {}, {}", self.what, self.words()));
        }
        let low = if self.open.0 { value > self.least } else { value >= self.least };
        let high = if self.open.1 { value < self.greatest } else { value <= self.greatest };
        (!(low && high)).then(|| format!("{value} is out of range; expected {}, {}", self.what, self.words()))
    }

    /// Range in words.
    pub(super) fn words(&self) -> String {
        let low = if self.open.0 { "greater than" } else { "at least" };
        let high = if self.open.1 { "less than" } else { "at most" };
        format!("{low} {} and {high} {}", self.least, self.greatest)
    }
}
