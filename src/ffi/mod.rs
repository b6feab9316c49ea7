//! The C ABI, over the public Rust API.
//!
//! The conventions are at the top of `include/cupola.h`, which is generated from these files. In
//! addition:
//!
//! - Each function is written out, so that the generator and readers see it; its body is a closure
//!   for `status::call`, through which no panic passes.
//! - Pointers are checked in one place each: `argument` (places for results, texts, arrays),
//!   `handle` (opaque objects) and `sized` (structs that grow).
//! - Outputs are checked before and written after everything that can fail.

#![allow(non_camel_case_types)]

mod argument;
pub mod gl;
mod handle;
pub mod log;
pub mod map;
pub mod rig;
mod sized;
mod status;
mod version;
mod view;
pub mod vk;

pub use status::{cupola_last_error, cupola_status};
pub use version::{CUPOLA_ABI_VERSION, CUPOLA_API_VERSION, cupola_abi_version, cupola_api_version, cupola_version};
