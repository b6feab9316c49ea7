//! Boxes around vertices.

use glam::DVec3;

/// A box around positions in object coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    low: DVec3,
    high: DVec3,
    /// True if something of unknown position was added.
    unknown: bool,
}

impl Bounds {
    /// Box around nothing.
    pub const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY, unknown: false };
    /// Box around something of unknown position.
    pub const UNKNOWN: Self = Self { unknown: true, ..Self::EMPTY };

    /// Extends the box to a vertex. If the vertex is not finite or its fourth coordinate is not 1,
    /// its position counts as unknown.
    pub fn add(&mut self, [x, y, z, w]: [f64; 4]) {
        if w != 1.0 || !(x + y + z).is_finite() {
            self.unknown = true;
            return;
        }
        self.low = self.low.min(DVec3::new(x, y, z));
        self.high = self.high.max(DVec3::new(x, y, z));
    }

    /// Extends the box to the box `other`.
    pub fn join(&mut self, other: &Self) {
        match other.known() {
            Some((low, high)) => [low, high].into_iter().for_each(|corner| self.add(corner.extend(1.0).to_array())),
            None => self.unknown = true,
        }
    }

    /// Notes that something of unknown position was added.
    pub fn add_unknown(&mut self) {
        self.unknown = true;
    }

    /// Returns the lowest and the highest corner; `None` if they are not known. A box without
    /// vertices is not known either, as Cupola may not have seen them.
    pub fn known(&self) -> Option<(DVec3, DVec3)> {
        (!self.unknown && self.low.x <= self.high.x).then_some((self.low, self.high))
    }
}
