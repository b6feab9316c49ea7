//! The ideal fisheye lens.

/// An equidistant fisheye: the distance from the image's centre grows in proportion to the angle from the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fisheye {
    /// The whole opening angle in radians, 0 < aperture ≤ 2π; the rim of the unit disc lies at half of it.
    pub aperture: f64,
}
