//! Lenses: conversion of a direction to a position in a picture, and back.
//!
//! `fisheye` has the formulas of fisheye lenses. `lens` is any lens of a projector or of the
//! program. `optics` is such a lens with its position and direction, and optionally a mirror.
//! `panorama` is a picture of all directions, `content` one in a part of a window. `pinhole_rays`
//! are the rays of a pinhole in front of a screen with a formula. For shaders, `equidistant` has
//! polynomials of fisheyes, and `picture_map` converts a vertex to a position in a picture.

pub mod content;
pub mod equidistant;
pub mod fisheye;
pub mod lens;
pub mod optics;
pub mod panorama;
pub mod picture_map;
pub mod pinhole_rays;
