//! Deterministic random inputs, for tests and stress runs.

use glam::{DMat3, DVec3};

/// A SplitMix64 generator (Steele, Lea, Flood 2014): small, and the same everywhere.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A generator that always gives the same numbers for the same seed.
    ///
    /// The seed is mixed: were it the state itself, or a multiple of the step, neighbouring seeds could give the
    /// same numbers, one after the other.
    pub fn new(seed: u64) -> Self {
        Self(mixed(seed))
    }

    /// Uniform in 0…1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mixed(self.0) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in `low`…`high`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Each component uniform in `low`…`high`.
    pub fn vector(&mut self, low: f64, high: f64) -> DVec3 {
        DVec3::new(self.range(low, high), self.range(low, high), self.range(low, high))
    }

    /// Uniform on the unit sphere (z and azimuth uniform: Archimedes).
    pub fn direction(&mut self) -> DVec3 {
        let z = self.range(-1.0, 1.0);
        let (sine, cosine) = self.range(0.0, std::f64::consts::TAU).sin_cos();
        let h = (1.0 - z * z).sqrt();
        DVec3::new(h * cosine, h * sine, z)
    }

    /// A rotation of any angle about any axis.
    pub fn rotation(&mut self) -> DMat3 {
        let axis = self.direction();
        DMat3::from_axis_angle(axis, self.range(0.0, std::f64::consts::TAU))
    }
}

/// Every bit of the result depends on every bit of `z`.
fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_seeds_share_no_numbers() {
        let numbers = |seed| {
            let mut random = Random::new(seed);
            (0..100).map(|_| random.unit().to_bits()).collect::<std::collections::BTreeSet<_>>()
        };
        for seed in 0..20 {
            assert!(numbers(seed).is_disjoint(&numbers(seed + 1)), "{seed}");
        }
    }
}
