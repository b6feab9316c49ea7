//! A deterministic generator of random input, for tests and for the laboratory.
//!
//! The library itself needs none. Integration tests, `cupola-lab` and the unit tests of `cupola`
//! include this file by its path.

#![allow(dead_code, reason = "each program that includes this file needs only a part of it")]

use glam::{DMat3, DVec2, DVec3};

/// A SplitMix64 generator (Steele, Lea, Flood 2014): small, and the same on every machine.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A generator that gives the same numbers for the same seed.
    ///
    /// The seed is mixed. Otherwise two seeds that differ by the generator's step would give the
    /// same numbers, moved by one place.
    pub fn new(seed: u64) -> Self {
        Self(mixed(seed))
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mixed(self.0)
    }

    /// Uniform in 0…`end`, without `end`. An `end` of 0 counts as 1.
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % end.max(1) as u64) as usize
    }

    /// Uniform in 0…1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in `low`…`high`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Each component uniform in `low`…`high`.
    pub fn vector(&mut self, low: f64, high: f64) -> DVec3 {
        DVec3::new(self.range(low, high), self.range(low, high), self.range(low, high))
    }

    /// Uniform on the unit sphere (z and azimuth are uniform: Archimedes).
    pub fn direction(&mut self) -> DVec3 {
        let z = self.range(-1.0, 1.0);
        let (sine, cosine) = self.range(0.0, std::f64::consts::TAU).sin_cos();
        let h = (1.0 - z * z).sqrt();
        DVec3::new(h * cosine, h * sine, z)
    }

    /// Two independent coordinates with normal distribution and standard deviation 1 (Box and
    /// Muller 1958).
    pub fn gaussian(&mut self) -> DVec2 {
        let length = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        length * DVec2::from_angle(self.range(0.0, std::f64::consts::TAU))
    }

    /// A rotation by any angle about any axis.
    pub fn rotation(&mut self) -> DMat3 {
        let axis = self.direction();
        DMat3::from_axis_angle(axis, self.range(0.0, std::f64::consts::TAU))
    }
}

/// A hash in which every bit of the result depends on every bit of `z`.
fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
