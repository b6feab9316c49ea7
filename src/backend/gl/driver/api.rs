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

/// Returns the core name of a command: the name itself, or the name of which the registry calls it
/// an alias.
pub fn core_name(name: &str) -> &str {
    let mut name = name;
    // An alias may point at another alias; the registry has no cycles.
    while let Ok(found) = ALIASES.binary_search_by(|pair| pair.0.cmp(name)) {
        name = ALIASES[found].1;
    }
    name
}

/// Kinds of contexts that lack a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outside {
    /// Contexts of the core profile lack it.
    pub core: bool,
    /// Contexts of OpenGL ES 2 and 3 lack it.
    pub es: bool,
}

impl Outside {
    /// Returns the kinds of contexts that lack the command with this core name.
    pub const fn of(name: &str) -> Self {
        Self { core: is_in(&OUTSIDE_CORE, name), es: is_in(&OUTSIDE_ES, name) }
    }
}

/// Tests whether a sorted list contains this name.
const fn is_in(list: &[&str], name: &str) -> bool {
    let (mut first, mut end) = (0, list.len());
    while first < end {
        let middle = first.midpoint(end);
        let (candidate, name) = (list[middle].as_bytes(), name.as_bytes());
        let mut at = 0;
        while at < candidate.len() && at < name.len() && candidate[at] == name[at] {
            at += 1;
        }
        if at == candidate.len() && at == name.len() {
            return true;
        }
        if at < name.len() && (at == candidate.len() || candidate[at] < name[at]) {
            first = middle + 1;
        } else {
            end = middle;
        }
    }
    false
}

impl Gl {
    /// Returns a string of the current context's driver, such as `GL_VERSION`; empty if the driver
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

#[cfg(test)]
mod tests {
    use super::Outside;

    #[test]
    fn the_registry_says_what_a_context_lacks() {
        let lacking = [("glBegin", true, true), ("glPushAttrib", true, true), ("glDrawBuffer", false, true)];
        // Removed from the core profile in OpenGL 3.2 and added again in 4.3; in an extension of
        // desktop OpenGL; in OpenGL ES under another name.
        let having = [
            ("glGetPointerv", false, false),
            ("glFramebufferDrawBufferEXT", false, true),
            ("glMapBuffer", false, false),
        ];
        for (name, core, es) in lacking.into_iter().chain(having) {
            assert_eq!(Outside::of(name), Outside { core, es }, "{name}");
        }
        assert_eq!(Outside::of("glViewport"), Outside { core: false, es: false });
    }
}
