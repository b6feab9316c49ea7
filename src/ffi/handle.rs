//! Objects that C holds by opaque pointers: created, borrowed and freed in one way.

use super::argument::{Place, check_pointer};
use crate::error::Result;

/// A type that C knows only by its pointer. The pointer is that of a [`Box`], so that its type
/// determines how it is freed.
pub(super) trait Handle: Sized {
    /// Name of the parameter, for messages.
    const NAME: &'static str;

    /// Gives the object to the caller, who frees it with the function that calls [`Handle::take`].
    fn give(self, place: Place<*mut Self>) {
        place.set(Box::into_raw(Box::new(self)));
    }

    /// Borrows the object.
    ///
    /// # Safety
    /// `handle` is null, or live and not changed by another thread during `'a`.
    unsafe fn borrow<'a>(handle: *const Self) -> Result<&'a Self> {
        check_pointer(handle, Self::NAME)?;
        // SAFETY: not null and aligned; live by this function's contract.
        Ok(unsafe { &*handle })
    }

    /// Borrows the object for changes.
    ///
    /// # Safety
    /// `handle` is null, or live and not used by another thread during `'a`.
    unsafe fn borrow_mut<'a>(handle: *mut Self) -> Result<&'a mut Self> {
        check_pointer(handle, Self::NAME)?;
        // SAFETY: not null and aligned; live and not shared by this function's contract.
        Ok(unsafe { &mut *handle })
    }

    /// Takes the object back; `None` for null.
    ///
    /// # Safety
    /// `handle` is null, or live and never used again.
    unsafe fn take(handle: *mut Self) -> Option<Box<Self>> {
        // SAFETY: a live handle comes from `Box::into_raw` in `Handle::give`.
        (!handle.is_null()).then(|| unsafe { Box::from_raw(handle) })
    }
}
