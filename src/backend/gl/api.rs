//! The OpenGL API: a table of the driver's entry points with one method per command
//! (`gl.draw_arrays(…)`), the enums under their registry names, and the map of aliases.
//!
//! Generated at build time from the Khronos registry. A command that the driver lacks does
//! nothing and answers zero; ask `has_…` first where that matters.

#![allow(
    missing_docs,
    non_upper_case_globals,
    clippy::missing_safety_doc,
    clippy::too_many_arguments,
    clippy::unnecessary_cast
)]

use std::ffi::{c_char, c_void};

include!(concat!(env!("OUT_DIR"), "/gl_api.rs"));

// SAFETY: the table holds only addresses of functions, which any thread may read.
unsafe impl Send for Gl {}
// SAFETY: as above; the table never changes after it is loaded.
unsafe impl Sync for Gl {}

/// The core name of a command: itself, or what the registry calls it an alias of.
pub fn core_name(name: &str) -> &str {
    let mut name = name;
    // An alias may point at another alias; the registry has no cycles.
    while let Ok(found) = ALIASES.binary_search_by(|pair| pair.0.cmp(name)) {
        name = ALIASES[found].1;
    }
    name
}

impl Gl {
    /// Whether the current context is OpenGL ES.
    pub fn is_es(&self) -> bool {
        // SAFETY: the string is the driver's and lives as long as it.
        unsafe {
            let version = self.get_string(GL_VERSION);
            !version.is_null() && std::ffi::CStr::from_ptr(version.cast()).to_bytes().starts_with(b"OpenGL ES")
        }
    }
}
