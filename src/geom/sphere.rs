//! The dome as a sphere.

use glam::DVec3;

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, metres.
    pub center: DVec3,
    /// Radius, metres, > 0.
    pub radius: f64,
}
