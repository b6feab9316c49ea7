//! TODO-NOTE

pub mod atlas;
pub mod idle;
pub mod layout;
