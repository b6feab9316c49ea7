//! Lenses: from a direction to a place in a picture and back.
//!
//! `projection` has the formulas of fisheye lenses; `lens` is any lens of a projector or of the
//! program, `optics` such a lens in its place, perhaps before a mirror, `panorama` a picture of all
//! directions, `content` one in a part of a window. `pinhole_rays` are the rays of a pinhole before
//! a screen with a formula. For shaders: `fisheye` has polynomials of the ideal fisheye,
//! `picture_map` the way from a vertex to a picture.

pub mod content;
pub mod equidistant;
pub mod fisheye;
pub mod lens;
pub mod optics;
pub mod panorama;
pub mod picture_map;
pub mod pinhole_rays;
