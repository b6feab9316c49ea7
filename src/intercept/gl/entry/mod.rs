//! TODO-NOTE

pub mod egl;
pub mod glx;
pub mod table;
pub mod vendor;
