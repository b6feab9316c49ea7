//! Pointers that C passes: checks, texts, and places for results.

use crate::error::{Error, ErrorKind, Result};
use std::ffi::{CStr, c_char};

/// Error for an argument that must not be null.
pub(super) fn null(name: &str) -> Error {
    Error::new(ErrorKind::InvalidArgument, format!("`{name}` is null"))
}

/// Refuses null and misaligned pointers.
pub(super) fn check_pointer<T>(pointer: *const T, name: &str) -> Result<()> {
    if pointer.is_null() {
        return Err(null(name));
    }
    if !pointer.is_aligned() {
        let message = format!("`{name}` is {pointer:p}; expected an address that is a multiple of {}", align_of::<T>());
        return Err(Error::new(ErrorKind::InvalidArgument, message));
    }
    Ok(())
}

/// Memory of the caller for one result. It is only written.
pub(super) struct Place<T>(*mut T);

impl<T> Place<T> {
    /// Checks the pointer.
    ///
    /// # Safety
    /// `place` is null, misaligned, or writable until [`Place::set`] returns.
    pub(super) unsafe fn new(place: *mut T, name: &str) -> Result<Self> {
        check_pointer(place, name)?;
        Ok(Self(place))
    }

    /// Writes the result.
    pub(super) fn set(self, value: T) {
        // SAFETY: `Place::new` found the pointer aligned and not null, and its caller promises the
        // rest.
        unsafe { self.0.write(value) };
    }
}

/// Copies an array of `N` numbers.
///
/// # Safety
/// `array` is null, misaligned, or points to `N` readable elements.
pub(super) unsafe fn array<T: Copy, const N: usize>(array: *const T, name: &str) -> Result<[T; N]> {
    check_pointer(array, name)?;
    // SAFETY: not null, aligned as a `T`, and `N` elements by this function's contract.
    Ok(unsafe { array.cast::<[T; N]>().read() })
}

/// Text of a C string.
///
/// # Safety
/// `text` is null or NUL-terminated, and not changed while the result lives.
pub(super) unsafe fn text<'a>(text: *const c_char, name: &str) -> Result<&'a str> {
    check_pointer(text, name)?;
    // SAFETY: not null, and NUL-terminated by this function's contract.
    unsafe { CStr::from_ptr(text) }
        .to_str()
        .map_err(|_| Error::new(ErrorKind::InvalidArgument, format!("`{name}` is not UTF-8")))
}

/// Copies a text into the caller's buffer, cut to `size` bytes with its NUL, and writes the length
/// of the whole text.
///
/// # Safety
/// `buffer` is null or has room for `size` bytes; `length` is null or writable.
pub(super) unsafe fn copy_text(text: &str, buffer: *mut c_char, size: usize, length: *mut usize) {
    if !buffer.is_null() && size > 0 {
        // The text is cut between characters.
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
        // SAFETY: writable by this function's contract.
        unsafe { *length = text.len() };
    }
}
