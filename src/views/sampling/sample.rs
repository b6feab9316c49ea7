//! A direction that an output shows, and how densely pixels sample around it.

use glam::{DMat3, DVec3};

/// A direction that an output shows, and how densely its pixels sample around it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Direction from the viewer, viewer axes, unit length.
    pub direction: DVec3,
    /// `J·Jᵀ`, where J holds the change of the direction over one pixel to the right and over one
    /// pixel down: the shape of a pixel's disc on the sphere of directions, in squared radians.
    pub spread: DMat3,
}

/// Returns the mean direction, or straight ahead if there is none.
pub(crate) fn mean_direction<'a>(samples: impl Iterator<Item = &'a Sample>) -> DVec3 {
    samples.map(|sample| sample.direction).sum::<DVec3>().normalize_or(DVec3::NEG_Z)
}

/// Makes a sample from a direction and a spread of any common scale; `None` where they are
/// degenerate.
pub(super) fn of_unit_length(direction: DVec3, spread: DMat3) -> Option<Sample> {
    let squared = direction.length_squared();
    let usable = squared > 0.0 && squared.is_finite() && spread.is_finite();
    usable.then(|| Sample { direction: direction / squared.sqrt(), spread: spread * (1.0 / squared) })
}

/// Returns `a·bᵀ`.
pub(super) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
