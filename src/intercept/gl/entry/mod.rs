//! TODO-NOTE

pub mod attach;
pub mod contexts;
pub mod egl;
pub mod glx;
pub mod table;
pub mod vendor;
