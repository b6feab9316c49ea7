//! TODO-NOTE

pub mod division_counter;
pub mod fallback;
pub mod fixed_function;
pub mod geometry_stage;
pub mod interface;
pub mod lens;
pub mod tessellation;
pub mod uniform_mirror;
pub mod variants;
