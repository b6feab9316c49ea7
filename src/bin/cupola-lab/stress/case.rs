//! A random rig, and what random rigs are made of.

use crate::random::Random;
use cupola::rig::Rig;
use glam::DVec3;

/// A rig that the reader accepts.
pub struct Case {
    /// The rig.
    pub rig: Rig,
    /// Its file.
    pub text: String,
    /// How well-conditioned its geometry is.
    pub place: Place,
}

/// Where viewer and projectors are, in radii from the dome's centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Within 0.9.
    Inside,
    /// Near the screen or outside.
    Far,
}

/// How often a random rig may be refused (a projector that misses the screen) before a plain one is taken.
pub const ATTEMPTS: usize = 64;

/// The rig that stands in where all random ones are refused.
pub const PLAIN: &str = "[[output]]\nkind = \"domemaster\"\n";

/// One value of a list.
pub fn pick<T: Copy>(random: &mut Random, values: &[T]) -> T {
    values[((random.unit() * values.len() as f64) as usize).min(values.len() - 1)]
}

/// A vector as rig files have it.
pub fn vector(v: DVec3) -> String {
    format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
}
