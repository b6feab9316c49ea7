//! TODO-NOTE

pub mod atlas_layout;
pub mod create;
pub mod formats;
pub mod own_image;
pub mod present;
pub mod read_back;
pub mod stand_in;
