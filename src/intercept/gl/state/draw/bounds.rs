//! Boxes around vertices.

/// A box around positions in object coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
    /// True if something of unknown position was added.
    unknown: bool,
}

impl Bounds {
    /// Box around nothing.
    pub const EMPTY: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3], unknown: false };
    /// Box around something of unknown position.
    pub const UNKNOWN: Self = Self { unknown: true, ..Self::EMPTY };

    /// Extends the box to a vertex. If the vertex is not finite or its fourth coordinate is not 1,
    /// its position counts as unknown.
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

    /// Extends the box to the box `other`.
    pub fn join(&mut self, other: &Self) {
        match other.known() {
            Some((low, high)) => [low, high].into_iter().for_each(|[x, y, z]| self.add([x, y, z, 1.0])),
            None => self.unknown = true,
        }
    }

    /// Notes that something of unknown position was added.
    pub fn add_unknown(&mut self) {
        self.unknown = true;
    }

    /// Returns the lowest and the highest corner; `None` if they are not known. A box without
    /// vertices is not known either, as Cupola may not have seen them.
    pub fn known(&self) -> Option<([f64; 3], [f64; 3])> {
        (!self.unknown && self.low[0] <= self.high[0]).then_some((self.low, self.high))
    }
}
