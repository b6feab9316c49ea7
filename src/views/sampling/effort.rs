//! Limit of the work and the memory for one plan.

/// Greatest number of places at which the outputs of one plan are sampled, about 800 MB. Where each
/// ray goes through a mesh of triangles, these are about two minutes of one processor.
pub(crate) const MOST_PLACES: u64 = 1 << 23;

/// Number of places that a plan may still sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    left: u64,
}

impl Effort {
    /// Effort for a new plan.
    pub fn of_plan() -> Self {
        Self { left: MOST_PLACES }
    }

    /// Effort of up to `places`.
    #[cfg(test)]
    pub fn of(places: u64) -> Self {
        Self { left: places }
    }

    /// Number of places that are left.
    #[cfg(test)]
    pub fn left(&self) -> u64 {
        self.left
    }

    /// Takes `places` from what is left. Returns false if there were too few.
    pub fn take(&mut self, places: u64) -> bool {
        let enough = places < self.left;
        self.left = self.left.saturating_sub(places);
        enough
    }

    /// True if nothing is left.
    pub fn is_spent(&self) -> bool {
        self.left == 0
    }
}
