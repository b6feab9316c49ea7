//! TODO-NOTE

pub mod capture;
pub mod draw_count;
pub mod frame_number;
pub mod front_buffer;
pub mod present;
