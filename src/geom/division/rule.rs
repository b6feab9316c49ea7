//! Numbers of the rule that decides which edges are cut. The build script includes this file, too,
//! for the shaders that it generates. So the file uses nothing of the library.

/// Greatest width of an edge as the viewer sees it (radians, 22.5°). Wider edges are always cut,
/// since a longer curve can bend to both sides, with its middle on the straight line.
pub const WIDEST: f64 = std::f64::consts::FRAC_PI_8;
/// Square of the greatest width of an edge (radians), times pixels per radian, divided by the
/// allowed error. Edges of this width keep the inside of a triangle within the allowed error. The
/// number was found by trial; the tests measure the error.
pub const WIDTH_SQUARED: f64 = 60.0;
/// Width (radians) down to which an edge is cut if one of its ends has no place near the picture.
pub const NARROWEST: f64 = 0.003;
/// Error that the middle of an edge may have, as a part of the allowed error. Elsewhere on the
/// edge, and inside a triangle, the error is greater by a third at most.
pub const EDGE_SHARE: f64 = 0.7;
/// Distance from the picture's middle, in halves of the picture, beyond which the shape of an edge
/// does not count.
pub const OUTSIDE: f64 = 1.05;
