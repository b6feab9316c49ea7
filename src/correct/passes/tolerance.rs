//! Errors that evaluation in f32 may make in what a pixel shows.

/// Width of the picture in whose pixels errors are estimated: what a small picture shows is then
/// held to what a large one needs.
pub(in crate::correct) const REFERENCE: f64 = 4096.0;
/// The error that is allowed, in such pixels.
pub(in crate::correct) const PIXELS: f64 = 0.002;
/// An angle that is allowed however narrow the pixels, radians: ten steps of f32.
pub(in crate::correct) const ANGLE: f64 = 6e-7;
/// Yet never more than this of a pixel of the picture's own: narrower ones would not be told apart.
pub(in crate::correct) const OWN_PIXELS: f64 = 0.25;
