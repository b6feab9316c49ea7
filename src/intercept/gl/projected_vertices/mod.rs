//! TODO-NOTE

pub mod carriers;
pub mod fixed_function;
pub mod geometry_stage;
pub mod interface;
pub mod lens;
pub mod tessellation;
pub mod variants;
