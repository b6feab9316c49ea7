//! The C ABI: thin, over the public Rust API.
//!
//! Grammar: every function is `cupola_<type>_<verb>` and returns a [`cupola_status`]; handles come
//! first, outputs last, and outputs are written only on success. `_free` and `_destroy` accept null.
//! Structs that may grow begin with `struct_size`. Strings are UTF-8 and NUL-terminated.
//! A handle may be used by one thread at a time. No panic crosses this border.

#![allow(non_camel_case_types)]

pub mod blend;
pub mod gl;
pub mod map;
pub mod projection;
pub mod rig;
mod status;
pub mod vk;
pub mod vk_projection;

pub use status::{cupola_last_error, cupola_status, cupola_version};
