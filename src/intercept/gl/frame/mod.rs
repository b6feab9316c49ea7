//! TODO-NOTE

pub mod capture;
pub mod frame_number;
pub mod front_buffer;
pub mod present;
