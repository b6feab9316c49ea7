//! TODO-NOTE

pub mod blocks;
pub mod blocks_cached;
pub mod builder;
pub mod cover;
pub mod footprints;
pub mod rectangles;
pub mod unsampled;
pub mod unsampled_cached;
