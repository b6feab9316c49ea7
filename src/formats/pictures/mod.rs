//! Files with a value for each pixel, and black levels, which are such pictures.

pub(super) mod bmp;
pub mod levels;
pub mod pfm;
