//! Status codes, the detail of the last error, and the fence.

use crate::error::{Error, ErrorKind, Result};
use std::cell::RefCell;
use std::ffi::{CStr, c_char};

/// What became of a call. The numbers never change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum cupola_status {
    /// Done.
    CUPOLA_OK = 0,
    /// An argument is null, out of range or of the wrong size.
    CUPOLA_INVALID_ARGUMENT = 1,
    /// A rig says something impossible, unknown or misspelt.
    CUPOLA_INVALID_RIG = 2,
    /// A file could not be read or written.
    CUPOLA_IO = 3,
    /// The graphics driver lacks something that is needed, or refused a request.
    CUPOLA_GRAPHICS = 4,
    /// A call came in the wrong order.
    CUPOLA_INVALID_STATE = 5,
    /// A defect of Cupola itself.
    CUPOLA_INTERNAL = 6,
}

impl From<ErrorKind> for cupola_status {
    fn from(kind: ErrorKind) -> Self {
        match kind {
            ErrorKind::InvalidArgument => Self::CUPOLA_INVALID_ARGUMENT,
            ErrorKind::InvalidRig => Self::CUPOLA_INVALID_RIG,
            ErrorKind::Io => Self::CUPOLA_IO,
            ErrorKind::Graphics => Self::CUPOLA_GRAPHICS,
            ErrorKind::InvalidState => Self::CUPOLA_INVALID_STATE,
            ErrorKind::Internal => Self::CUPOLA_INTERNAL,
        }
    }
}

thread_local! {
    static LAST_ERROR: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Runs the body of a C function: errors and panics become a status and the last error.
pub(super) fn call(body: impl FnOnce() -> Result<()>) -> cupola_status {
    let result = crate::fence::guard(body)
        .unwrap_or_else(|| Err(Error::new(ErrorKind::Internal, "a defect of Cupola; please report how to repeat it")));
    match result {
        Ok(()) => cupola_status::CUPOLA_OK,
        Err(error) => {
            LAST_ERROR.with(|last| *last.borrow_mut() = error.message);
            error.kind.into()
        }
    }
}

/// An argument must not be null.
pub(super) fn null(name: &str) -> Error {
    Error::new(ErrorKind::InvalidArgument, format!("`{name}` is null"))
}

/// The text of a C string.
///
/// # Safety
/// `text` is null or NUL-terminated.
pub(super) unsafe fn text<'a>(text: *const c_char, name: &str) -> Result<&'a str> {
    if text.is_null() {
        return Err(null(name));
    }
    // SAFETY: as promised above.
    unsafe { CStr::from_ptr(text) }
        .to_str()
        .map_err(|_| Error::new(ErrorKind::InvalidArgument, format!("`{name}` is not UTF-8")))
}

/// Checks the `struct_size` that a program gave for a struct of `known` bytes.
pub(super) fn check_size(given: usize, known: usize, name: &str) -> Result<()> {
    if given < known {
        let message = format!("`{name}.struct_size` is {given}; right would be sizeof(*{name}), at least {known}");
        return Err(Error::new(ErrorKind::InvalidArgument, message));
    }
    Ok(())
}

/// A name as structs hold it: NUL-terminated, cut to 31 bytes.
pub(super) fn name_of(name: &str) -> [c_char; 32] {
    let mut held = [0; 32];
    for (to, from) in held.iter_mut().zip(name.bytes().take(31)) {
        *to = from as c_char;
    }
    held
}

/// Copies the detail of the last error of this thread, cut to `size` bytes with its NUL.
///
/// `buffer`: room for `size` bytes, or null to ask only for the length. `length` (may be null): the
/// whole detail's length in bytes without the NUL. Before any error the detail is empty. The detail
/// stays until the next error.
///
/// # Safety
/// `buffer` has room for `size` bytes or is null; `length` is null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_last_error(buffer: *mut c_char, size: usize, length: *mut usize) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        LAST_ERROR.with(|last| unsafe { copy_text(&last.borrow(), buffer, size, length) });
        Ok(())
    })
}

/// Copies a text for a program, cut to `size` bytes with its NUL, and tells its length.
///
/// # Safety
/// `buffer` has room for `size` bytes or is null; `length` is null or writable.
pub(super) unsafe fn copy_text(text: &str, buffer: *mut c_char, size: usize, length: *mut usize) {
    if !buffer.is_null() && size > 0 {
        // The cut keeps whole characters.
        let mut count = text.len().min(size - 1);
        while !text.is_char_boundary(count) {
            count -= 1;
        }
        // SAFETY: `count` + 1 ≤ `size` bytes, for which there is room.
        unsafe {
            std::ptr::copy_nonoverlapping(text.as_ptr(), buffer.cast(), count);
            *buffer.add(count) = 0;
        }
    }
    if !length.is_null() {
        // SAFETY: writable, as promised above.
        unsafe { *length = text.len() };
    }
}

/// The version of the library, major, minor and patch; each pointer may be null.
///
/// # Safety
/// Each pointer is null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_version(major: *mut u32, minor: *mut u32, patch: *mut u32) -> cupola_status {
    call(|| {
        let parts = [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR"), env!("CARGO_PKG_VERSION_PATCH")];
        for (pointer, part) in [major, minor, patch].into_iter().zip(parts) {
            if !pointer.is_null() {
                // SAFETY: writable, as promised above.
                unsafe { *pointer = part.parse().unwrap_or(0) };
            }
        }
        Ok(())
    })
}
