//! A checksum of the program's calls in a frame. It shows whether several machines do the same.
//!
//! It covers the calls that Cupola intercepts, with their numeric arguments, and the matrices,
//! vectors and buffers that they point at. Pointers are left out because they differ between
//! processes. Queries of state are left out because a program may repeat them any number of times.
//! Names of objects are replaced by the order in which they came: Cupola has other objects on each
//! machine, so that the driver gives the program other names.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};

static ON: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// The checksum of this thread's calls. Only the thread that swaps is compared.
    static SUM: Cell<u64> = const { Cell::new(0) };

    /// Numbers of the objects' names of this thread, by the parameter and the name.
    static NAMES: RefCell<HashMap<(&'static str, u64), u64>> = RefCell::default();
}

/// Greatest number of names that are kept. After that, all nodes count anew.
const MOST_NAMES: usize = 1 << 18;

/// Starts to sum up calls.
pub fn begin() {
    ON.store(true, Ordering::Relaxed);
}

/// True if calls are summed up.
#[inline]
pub fn is_on() -> bool {
    ON.load(Ordering::Relaxed)
}

/// Adds a number.
pub fn add(number: u64) {
    SUM.set((SUM.get().rotate_left(5) ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15));
}

/// Adds `count` values that a call points at, if calls are summed up.
///
/// # Safety
/// `values` must be null or point at `count` values, as the program promises OpenGL.
#[inline]
pub unsafe fn add_values<T: Copy>(values: *const T, count: usize) {
    if is_on() && !values.is_null() {
        // SAFETY: as promised.
        let bytes = unsafe { std::slice::from_raw_parts(values.cast::<u8>(), count * size_of::<T>()) };
        add(xxhash_rust::xxh3::xxh3_64(bytes));
    }
}

/// Returns the sum since the last call of this function.
pub fn take() -> u64 {
    SUM.replace(0)
}

/// Returns a call's number in the sum; 0 for a query of state.
pub const fn code(name: &str) -> u64 {
    let bytes = name.as_bytes();
    let is_question = bytes.len() > 4
        && (matches!(bytes, [b'g', b'l', b'G', b'e', b't', ..]) || matches!(bytes, [b'g', b'l', b'I', b's', ..]));
    if is_question {
        return 0;
    }
    let (mut code, mut index) = (0xcbf2_9ce4_8422_2325_u64, 0);
    while index < bytes.len() {
        code = (code ^ bytes[index] as u64).wrapping_mul(0x0100_0000_01b3);
        index += 1;
    }
    code
}

/// True if a parameter with this name in a hook is the name of an object, or may be one.
pub const fn is_name(parameter: &str) -> bool {
    matches!(
        parameter.as_bytes(),
        b"array"
            | b"buffer"
            | b"destination"
            | b"feedback"
            | b"framebuffer"
            | b"id"
            | b"list"
            | b"name"
            | b"object"
            | b"pipeline"
            | b"program"
            | b"query"
            | b"read"
            | b"renderbuffer"
            | b"shader"
            | b"source"
            | b"texture"
            | b"write"
    )
}

/// Adds the number of an object's name: how many other names came before it. 0 is no name.
pub fn add_name(parameter: &'static str, name: u64) {
    let number = NAMES.with_borrow_mut(|names| {
        if names.len() >= MOST_NAMES {
            names.clear();
        }
        let next = names.len() as u64 + 1;
        if name == 0 { 0 } else { *names.entry((parameter, name)).or_insert(next) }
    });
    add(number);
}

/// A parameter of a call.
pub trait Parameter: Copy {
    /// Returns the value that is added to the sum.
    fn number(self) -> u64;
}

macro_rules! integers {
    ($($kind:ty)*) => {
        $(impl Parameter for $kind {
            fn number(self) -> u64 {
                self as u64
            }
        })*
    };
}
integers!(u8 i8 u16 i16 u32 i32 u64 i64 usize isize);

impl Parameter for f32 {
    fn number(self) -> u64 {
        self.to_bits().into()
    }
}

impl Parameter for f64 {
    fn number(self) -> u64 {
        self.to_bits()
    }
}

impl<T> Parameter for *const T {
    fn number(self) -> u64 {
        self.is_null().into()
    }
}

impl<T> Parameter for *mut T {
    fn number(self) -> u64 {
        self.is_null().into()
    }
}

/// Adds a call with its parameters.
macro_rules! add_call {
    ($name:literal $(, $parameter:expr)*) => {
        if $crate::intercept::process::call_sum::is_on() {
            const CODE: u64 = $crate::intercept::process::call_sum::code($name);
            if CODE != 0 {
                $crate::intercept::process::call_sum::add(CODE);
                $({
                    const IS_NAME: bool = $crate::intercept::process::call_sum::is_name(stringify!($parameter));
                    let number = $crate::intercept::process::call_sum::Parameter::number($parameter);
                    match IS_NAME {
                        true => $crate::intercept::process::call_sum::add_name(stringify!($parameter), number),
                        false => $crate::intercept::process::call_sum::add(number),
                    }
                })*
            }
        }
    };
}
pub(crate) use add_call;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_and_numbers_count_and_pointers_and_questions_do_not() {
        let sum = |numbers: &[u64]| {
            numbers.iter().for_each(|number| add(*number));
            take()
        };
        assert_eq!(sum(&[1, 2]), sum(&[1, 2]));
        assert_ne!(sum(&[1, 2]), sum(&[2, 1]));
        assert_ne!(sum(&[0]), sum(&[0, 0]) ^ 1);
        assert_eq!((&raw const ON).number(), 0);
        assert_ne!(1.0_f32.number(), (-1.0_f32).number());
        assert_eq!((code("glGetError"), code("glIsEnabled")), (0, 0));
        let named = |names: &[u64]| {
            NAMES.take();
            names.iter().for_each(|name| add_name("texture", *name));
            take()
        };
        assert_eq!(named(&[5, 6, 5, 0]), named(&[70, 9, 70, 0]));
        assert_ne!(named(&[5, 6, 5]), named(&[70, 9, 9]));
        assert_ne!(named(&[5, 0]), named(&[5, 5]));
        assert!(is_name("texture") && !is_name("target"));
        assert!(code("glDrawArrays") != 0 && code("glDrawArrays") != code("glDrawElements"));
    }
}
