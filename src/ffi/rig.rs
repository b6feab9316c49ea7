//! Rigs.

use super::argument::{Place, text};
use super::handle::Handle;
use super::status::{call, cupola_status};
use crate::rig::{self, Rig};
use std::ffi::c_char;
use std::path::Path;

/// A rig: description of screen, viewer and outputs (projectors, domemasters, windows). Created by
/// `cupola_rig_load` or `cupola_rig_parse`, freed by `cupola_rig_free`. It does not change; several
/// threads may use it at the same time.
pub struct cupola_rig {
    pub(super) rig: Rig,
}

impl Handle for cupola_rig {
    const NAME: &'static str = "rig";
}

// Several threads may use one rig.
const _: fn() = || {
    fn is_shared<T: Send + Sync>() {}
    is_shared::<cupola_rig>();
};

/// Loads a rig from a preset or from a file.
///
/// # Parameters
/// - `name_or_path`: name of a preset (`fisheye`, `planetarium-6`, ...) or path of a rig file,
///   UTF-8.
/// - `rig`: receives the new rig, on success only.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, or a text that is not UTF-8.
/// - `CUPOLA_IO`: there is no such preset and no such file, or the file cannot be read.
/// - `CUPOLA_INVALID_RIG`: the file has mistakes; `cupola_last_error` names all of them with their
///   lines.
///
/// # Ownership
/// The caller owns `*rig` and frees it with `cupola_rig_free`.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `name_or_path` is NUL-terminated; `rig` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_rig_load(name_or_path: *const c_char, rig: *mut *mut cupola_rig) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (place, name) = unsafe { (Place::new(rig, "rig")?, text(name_or_path, "name_or_path")?) };
        cupola_rig { rig: rig::load(name)? }.give(place);
        Ok(())
    })
}

/// Reads a rig from a text in the format of rig files (TOML).
///
/// # Parameters
/// - `toml`: the text, UTF-8.
/// - `directory`: folder in which the files that the text names (masks, pictures of black, models)
///   are looked up, UTF-8.
/// - `rig`: receives the new rig, on success only.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, or a text that is not UTF-8.
/// - `CUPOLA_IO`: a file that the text names cannot be read.
/// - `CUPOLA_INVALID_RIG`: the text has mistakes; `cupola_last_error` names all of them with their
///   lines.
///
/// # Ownership
/// The caller owns `*rig` and frees it with `cupola_rig_free`.
///
/// # Threads
/// Any thread.
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
        // SAFETY: as this function's contract.
        let (place, toml, directory) =
            unsafe { (Place::new(rig, "rig")?, text(toml, "toml")?, text(directory, "directory")?) };
        cupola_rig { rig: rig::parse(toml, "the given text", Path::new(directory))? }.give(place);
        Ok(())
    })
}

/// Returns the number of outputs of a rig.
///
/// # Parameters
/// - `rig`: the rig.
/// - `count`: receives the number.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer.
///
/// # Threads
/// Any thread, and several at the same time with the same rig.
///
/// # Safety
/// `rig` is a live handle; `count` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_rig_output_count(rig: *const cupola_rig, count: *mut u32) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (rig, count) = unsafe { (cupola_rig::borrow(rig)?, Place::new(count, "count")?) };
        count.set(rig.rig.outputs.len() as u32);
        Ok(())
    })
}

/// Frees a rig. Objects that were created from it stay.
///
/// # Parameters
/// - `rig`: the rig, or null, which does nothing.
///
/// # Returns
/// `CUPOLA_OK`.
///
/// # Threads
/// Any thread; no other thread may use the rig at the same time.
///
/// # Safety
/// `rig` is a live handle or null. It must not be used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_rig_free(rig: *mut cupola_rig) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        drop(unsafe { cupola_rig::take(rig) });
        Ok(())
    })
}
