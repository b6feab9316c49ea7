//! Structs that grow at their end from version to version.
//!
//! Such a struct begins with `struct_size`, which the caller sets to its own `sizeof`. So the
//! library knows the caller's fields:
//!
//! - A smaller struct comes from a caller of an older version. Its missing fields are read as 0,
//!   and only the fields that it has are written. A struct smaller than the first published version
//!   is refused.
//! - A larger struct comes from a caller of a newer version. It is read if all bytes that this
//!   version does not know are 0, else it is refused. In results these bytes become 0.
//!
//! Rules for a new field: it stands at the end; it begins where the struct of the version before
//! ended (never in its padding); 0 means the behaviour without the field.

use super::argument::{check_pointer, null};
use crate::error::{Error, ErrorKind, Result};
use std::mem::MaybeUninit;

/// Struct of the C ABI that may grow.
///
/// # Safety
/// The type is `repr(C)`, its first field is `struct_size: usize`, and zero bytes and all values
/// that C can write are valid for each field.
pub(super) unsafe trait Growing: Sized {
    /// Size in bytes of the first published version.
    const FIRST_SIZE: usize;
}

/// `FIRST_SIZE` of a struct whose first published version ended with the field `$last`.
macro_rules! first_size {
    ($type:ty, $last:ident) => {{
        const fn end_of<S, F>(offset: usize, _: fn(&S) -> &F) -> usize {
            (offset + size_of::<F>()).next_multiple_of(align_of::<S>())
        }
        assert!(std::mem::offset_of!($type, struct_size) == 0);
        end_of::<$type, _>(std::mem::offset_of!($type, $last), |s| &s.$last)
    }};
}
pub(super) use first_size;

/// Greatest accepted size. A larger one is an uninitialised `struct_size`.
const LARGEST: usize = 4096;

/// Reads a struct of the caller.
///
/// # Safety
/// `from` is null, misaligned, or points to a struct of as many readable bytes as its `struct_size`
/// says.
pub(super) unsafe fn read<T: Growing>(from: *const T, name: &str) -> Result<T> {
    // SAFETY: as this function's contract.
    let size = unsafe { given_size(from, name) }?;
    // SAFETY: as this function's contract; the size was checked.
    unsafe { read_sized(from, size, name) }
}

/// Reads an array of structs. Their distance is the `struct_size` of the first one; that of the
/// others is ignored.
///
/// # Safety
/// `first` is null, misaligned, or points to `count` structs of as many readable bytes as the first
/// one says.
pub(super) unsafe fn read_array<T: Growing>(first: *const T, count: u32, name: &str) -> Result<Vec<T>> {
    if first.is_null() {
        return Err(null(name));
    }
    if count == 0 {
        return Ok(Vec::new());
    }
    // SAFETY: there is a first struct, by this function's contract.
    let size = unsafe { given_size(first, name) }?;
    // SAFETY: each struct has `size` bytes, by this function's contract.
    (0..count as usize).map(|index| unsafe { read_sized(first.byte_add(index * size), size, name) }).collect()
}

/// Memory of the caller for a struct. Only its `struct_size` is read.
pub(super) struct SizedPlace<T> {
    place: *mut T,
    size: usize,
}

impl<T: Growing> SizedPlace<T> {
    /// Checks the pointer and the size.
    ///
    /// # Safety
    /// `place` is null, misaligned, or points to a struct of as many bytes as its `struct_size`
    /// says, which are writable until [`SizedPlace::set`] returns.
    pub(super) unsafe fn new(place: *mut T, name: &str) -> Result<Self> {
        // SAFETY: as this function's contract.
        let size = unsafe { given_size(place, name) }?;
        Ok(Self { place, size })
    }

    /// Writes the fields that the caller has. The caller's `struct_size` stays; fields that this
    /// version does not know become 0.
    pub(super) fn set(self, value: &T) {
        let known = self.size.min(size_of::<T>());
        let head = size_of::<usize>();
        let (from, to) = (std::ptr::from_ref(value).cast::<u8>(), self.place.cast::<u8>());
        // SAFETY: `head` ≤ `known` ≤ the sizes of both structs (a first version has more than its
        // size), and `SizedPlace::new`'s caller promises `self.size` writable bytes.
        unsafe {
            std::ptr::copy_nonoverlapping(from.add(head), to.add(head), known - head);
            to.add(known).write_bytes(0, self.size - known);
        }
    }
}

/// Checked `struct_size` of the caller.
///
/// # Safety
/// `pointer` is null, misaligned, or points to a readable `struct_size`.
unsafe fn given_size<T: Growing>(pointer: *const T, name: &str) -> Result<usize> {
    check_pointer(pointer, name)?;
    // SAFETY: aligned and not null; the size is the first field of the struct.
    let size = unsafe { pointer.cast::<usize>().read() };
    let least = T::FIRST_SIZE;
    if (least..=LARGEST).contains(&size) && size.is_multiple_of(align_of::<T>()) {
        return Ok(size);
    }
    let (known, step) = (size_of::<T>(), align_of::<T>());
    let message = format!(
        "`{name}.struct_size` is {size}; expected sizeof(*{name}): {known} in this version, at least {least}, at most {LARGEST}, a multiple of {step}"
    );
    Err(Error::new(ErrorKind::InvalidArgument, message))
}

/// Reads a struct of `size` bytes.
///
/// # Safety
/// `from` is aligned and points to `size` readable bytes; `size` was checked.
unsafe fn read_sized<T: Growing>(from: *const T, size: usize, name: &str) -> Result<T> {
    let known = size.min(size_of::<T>());
    let bytes = from.cast::<u8>();
    // SAFETY: `known` ≤ `size` bytes are readable.
    let beyond = unsafe { std::slice::from_raw_parts(bytes.add(known), size - known) };
    if let Some(index) = beyond.iter().position(|byte| *byte != 0) {
        let message = format!(
            "`{name}` sets a field that this version does not know: byte {} is not 0, and `struct_size` is {known} in this version; use a newer library, or set that field to 0",
            known + index
        );
        return Err(Error::new(ErrorKind::InvalidArgument, message));
    }
    let mut value = MaybeUninit::<T>::zeroed();
    // SAFETY: `known` bytes are readable there and writable here. Fields that were not copied stay
    // 0, which is valid, as all that C can write is: `Growing` promises both.
    unsafe {
        std::ptr::copy_nonoverlapping(bytes, value.as_mut_ptr().cast::<u8>(), known);
        Ok(value.assume_init())
    }
}

#[cfg(test)]
mod tests;
