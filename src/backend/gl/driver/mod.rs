//! The driver: its function table, its errors, names of objects, and contexts without a program.

pub mod api;
pub mod errors;
pub mod glx;
pub mod headless;
pub mod own_names;
pub mod values;
