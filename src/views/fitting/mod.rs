//! TODO-NOTE

pub mod axes;
pub mod density;
pub mod fit;
pub mod lanes;
