//! Allowed errors of an evaluation in f32.

/// Width of the reference picture, in whose pixels errors are estimated. So a small picture has to
/// be as exact as a large one.
pub(in crate::correct) const REFERENCE: f64 = 4096.0;
/// Allowed error, in pixels of the reference.
pub(in crate::correct) const PIXELS: f64 = 0.002;
/// Angle that is allowed however narrow the pixels are, radians: ten steps of f32.
pub(in crate::correct) const ANGLE: f64 = 6e-7;
/// Limit of that angle, in the picture's own pixels: a greater error would confuse neighbouring
/// pixels.
pub(in crate::correct) const OWN_PIXELS: f64 = 0.25;
