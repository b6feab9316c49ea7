//! A random rig, and helpers for the generation of random rigs.

use crate::random::Random;
use cupola::rig::Rig;
use glam::DVec3;

/// A valid random rig.
pub struct Case {
    /// The rig.
    pub rig: Rig,
    /// Text of its rig file.
    pub text: String,
    /// Distance of viewer and projectors, which determines the bound.
    pub place: Place,
}

/// Distance of viewer and projectors from the centre of the dome, in radii.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Within 0.9.
    Inside,
    /// Near the screen or outside.
    Far,
}

/// Number of attempts to generate a valid random rig (a projector may miss the screen) before a
/// plain rig is used.
pub const ATTEMPTS: usize = 64;

/// The rig that is used if all random rigs are invalid.
pub const PLAIN: &str = "[[output]]\nkind = \"domemaster\"\n";

/// A random value of a list.
pub fn pick<T: Copy>(random: &mut Random, values: &[T]) -> T {
    values[((random.unit() * values.len() as f64) as usize).min(values.len() - 1)]
}

/// A vector as text for a rig file.
pub fn vector(v: DVec3) -> String {
    format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
}
