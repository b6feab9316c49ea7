//! Boxes around vertices.

/// A box around positions in object coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
    /// Something joined whose place is not known.
    unknown: bool,
}

impl Bounds {
    /// Around nothing.
    pub const EMPTY: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3], unknown: false };
    /// Around something somewhere.
    pub const UNKNOWN: Self = Self { unknown: true, ..Self::EMPTY };

    /// Grows to hold a vertex. One that is not finite, or has a fourth coordinate other than 1, is
    /// nowhere.
    pub fn add(&mut self, [x, y, z, w]: [f64; 4]) {
        if w != 1.0 || !(x + y + z).is_finite() {
            self.unknown = true;
            return;
        }
        for (axis, value) in [x, y, z].into_iter().enumerate() {
            self.low[axis] = self.low[axis].min(value);
            self.high[axis] = self.high[axis].max(value);
        }
    }

    /// Grows to hold what `other` holds.
    pub fn join(&mut self, other: &Self) {
        match other.known() {
            Some((low, high)) => [low, high].into_iter().for_each(|[x, y, z]| self.add([x, y, z, 1.0])),
            None => self.unknown = true,
        }
    }

    /// Something joined whose place is not known.
    pub fn add_unknown(&mut self) {
        self.unknown = true;
    }

    /// Lowest and highest corner. `None`: not known; so it is without any vertex, which may have
    /// come by a way that is not seen.
    pub fn known(&self) -> Option<([f64; 3], [f64; 3])> {
        (!self.unknown && self.low[0] <= self.high[0]).then_some((self.low, self.high))
    }
}
