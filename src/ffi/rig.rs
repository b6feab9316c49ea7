//! Rigs.

use super::status::{call, cupola_status, null, text};
use crate::rig::{self, Rig};
use std::ffi::c_char;
use std::path::Path;

/// A rig: what stands where. Immutable; free it with `cupola_rig_free`.
pub struct cupola_rig {
    pub(super) rig: Rig,
}

/// Loads a rig from a preset's name or a file.
///
/// # Safety
/// `name_or_path` is NUL-terminated; `rig` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_rig_load(name_or_path: *const c_char, rig: *mut *mut cupola_rig) -> cupola_status {
    call(|| {
        if rig.is_null() {
            return Err(null("rig"));
        }
        // SAFETY: as promised above.
        let loaded = rig::load(unsafe { text(name_or_path, "name_or_path") }?)?;
        // SAFETY: writable, as promised above.
        unsafe { *rig = Box::into_raw(Box::new(cupola_rig { rig: loaded })) };
        Ok(())
    })
}

/// Reads a rig from the text of a rig file. Masks and pictures of black are looked up in `directory`.
///
/// # Safety
/// `toml` and `directory` are NUL-terminated; `rig` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_rig_parse(
    toml: *const c_char,
    directory: *const c_char,
    rig: *mut *mut cupola_rig,
) -> cupola_status {
    call(|| {
        if rig.is_null() {
            return Err(null("rig"));
        }
        // SAFETY: as promised above.
        let (toml, directory) = unsafe { (text(toml, "toml")?, text(directory, "directory")?) };
        let parsed = rig::parse(toml, "the given text", Path::new(directory))?;
        // SAFETY: writable, as promised above.
        unsafe { *rig = Box::into_raw(Box::new(cupola_rig { rig: parsed })) };
        Ok(())
    })
}

/// How many outputs a rig has.
///
/// # Safety
/// `rig` is a live handle or null; `count` is writable or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_rig_output_count(rig: *const cupola_rig, count: *mut u32) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let (rig, count) =
            unsafe { (rig.as_ref().ok_or_else(|| null("rig"))?, count.as_mut().ok_or_else(|| null("count"))?) };
        *count = rig.rig.outputs.len() as u32;
        Ok(())
    })
}

/// Frees a rig; null is allowed. What was made from it lives on.
///
/// # Safety
/// `rig` is a live handle or null; it must not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_rig_free(rig: *mut cupola_rig) -> cupola_status {
    call(|| {
        if !rig.is_null() {
            // SAFETY: the handle came from Box::into_raw in `cupola_rig_load` or `cupola_rig_parse`.
            drop(unsafe { Box::from_raw(rig) });
        }
        Ok(())
    })
}
