//! TODO-NOTE

pub mod create;
pub mod present;
pub mod read_back;
pub mod stand_in;
