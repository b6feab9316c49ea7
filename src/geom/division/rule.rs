//! The numbers of the rule by which edges are cut. The build has them, too, for the shaders that it
//! makes, so that this file uses nothing of the library.

/// Edges wider than this as seen by the viewer (radians, 22.5°) are cut whatever their middle says:
/// curves bend to both sides on longer ones.
pub const WIDEST: f64 = std::f64::consts::FRAC_PI_8;
/// The square of the widest edge's width, radians, times pixels per radian over the error allowed:
/// then what is amid a triangle is within that error. Found by trying (the tests measure it).
pub const WIDTH_SQUARED: f64 = 60.0;
/// Edges that lead out of the picture and beyond are cut down to this width, radians.
pub const NARROWEST: f64 = 0.003;
/// The part of the error allowed that the middle of an edge may have: in between, and amid a
/// triangle, it is greater by a third at most.
pub const EDGE_SHARE: f64 = 0.7;
/// Distance from the picture's middle, in halves of the picture, beyond which the shape of an edge
/// does not count.
pub const OUTSIDE: f64 = 1.05;
