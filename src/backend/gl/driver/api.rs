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

use std::ffi::{CStr, c_char, c_void};

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
    /// A string of the driver, `GL_VERSION` and the like, whose context is current; empty where it
    /// has none.
    pub fn text(&self, name: u32) -> String {
        // SAFETY: the driver's strings end with a zero and live as long as it.
        unsafe {
            let text = self.get_string(name);
            if text.is_null() { String::new() } else { CStr::from_ptr(text.cast()).to_string_lossy().into_owned() }
        }
    }

    /// True if the current context is OpenGL ES.
    pub fn is_es(&self) -> bool {
        self.text(GL_VERSION).starts_with("OpenGL ES")
    }
}
