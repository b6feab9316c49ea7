//! Status codes, the message of the last error, and the barrier against panics.

use super::argument::copy_text;
use crate::error::{Error, ErrorKind, Result};
use std::cell::RefCell;
use std::ffi::c_char;

/// Result of a call. `cupola_last_error` copies the message of an error. Numbers never change, and
/// later versions may add some.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum cupola_status {
    /// Success.
    CUPOLA_OK = 0,
    /// An argument is null, misaligned, out of range or of a wrong size.
    CUPOLA_INVALID_ARGUMENT = 1,
    /// A rig has a mistake: an unknown key or an impossible value.
    CUPOLA_INVALID_RIG = 2,
    /// A file could not be read or written.
    CUPOLA_IO = 3,
    /// The graphics driver lacks something that is needed, refused a request or lost its device.
    CUPOLA_GRAPHICS = 4,
    /// The call is not allowed now, for example the end of a frame without its begin.
    CUPOLA_INVALID_STATE = 5,
    /// A defect of the library. Objects that took part in the call can only be destroyed.
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
        .unwrap_or_else(|| Err(Error::new(ErrorKind::Internal, "a defect of Cupola; please report how to trigger it")));
    match result {
        Ok(()) => cupola_status::CUPOLA_OK,
        Err(error) => {
            LAST_ERROR.with(|last| *last.borrow_mut() = error.message);
            error.kind.into()
        }
    }
}

/// Copies the message of the last error of the calling thread. It is empty before the first error
/// and stays until the next one; success does not change it.
///
/// # Parameters
/// - `buffer`: room for `size` bytes, or null to get the length only. The message is cut to fit,
///   with its NUL.
/// - `size`: size of the buffer in bytes.
/// - `length`: receives the length of the whole message in bytes without its NUL; may be null.
///
/// # Returns
/// `CUPOLA_OK`.
///
/// # Threads
/// Any thread. Each thread has a last error of its own.
///
/// # Safety
/// `buffer` has room for `size` bytes or is null; `length` is null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_last_error(buffer: *mut c_char, size: usize, length: *mut usize) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        LAST_ERROR.with(|last| unsafe { copy_text(&last.borrow(), buffer, size, length) });
        Ok(())
    })
}
