//! Common parts of the vendor wrappers of GLX and EGL.

use crate::intercept::gl::entry::table;
use crate::intercept::process::{log, settings};
use std::ffi::CStr;

/// Returns the entry point of a vendor library of libglvnd, which stays loaded. If there is none,
/// returns `None` and reports this in the log. `variable` is the environment variable by which a
/// user chooses the library.
///
/// # Safety
/// `T` must be the type of the function that libglvnd calls `symbol`.
pub unsafe fn entry<T: Copy>(file: &str, symbol: &CStr, variable: &str) -> Option<T> {
    // SAFETY: the vendor library is what libglvnd itself would have loaded.
    let Ok(library) = (unsafe { libloading::Library::new(file) }) else {
        log::once(&format!("{file} cannot be loaded: set {variable} to the OpenGL vendor of this system"));
        return None;
    };
    let library = Box::leak(Box::new(library));
    // SAFETY: as promised.
    match unsafe { library.get::<T>(symbol.to_bytes_with_nul()) } {
        Ok(entry) => Some(*entry),
        Err(_) => {
            let symbol = symbol.to_string_lossy();
            log::once(&format!("{file} has no {symbol}: it is not a vendor library of libglvnd"));
            None
        }
    }
}

/// True if the program's calls are to go through functions of Cupola.
pub fn wanted() -> bool {
    !settings::switched_off() && settings::settings().is_some()
}

/// Returns the function of Cupola that answers `name`; `None` if the rig corrects nothing. Then
/// Cupola only counts frames.
pub fn hook(name: &str) -> Option<*const ()> {
    let passthrough = settings::settings().is_none_or(|s| s.rig.passthrough);
    if passthrough { None } else { table::find(name) }
}

/// Calls the driver's function `$name` with the arguments `$a`. The function `real` of the calling
/// module finds it.
macro_rules! real_call {
    ($name:literal, ($($t:ty),*) -> $r:ty, $($a:expr),* $(,)?) => {{
        // SAFETY: the driver's function of this name has this signature; the arguments are the
        // program's.
        unsafe {
            let function: unsafe extern "C" fn($($t),*) -> $r = std::mem::transmute(real($name));
            function($($a),*)
        }
    }};
}

pub(crate) use real_call;

/// Functions that pass a call on and then note something about its `$answer`.
macro_rules! noted_calls {
    ($( $name:literal $function:ident ( $($p:ident: $t:ty),* ) -> $r:ty, |$answer:ident| $note:expr; )*) => {
        $(
            unsafe extern "C" fn $function($($p: $t),*) -> $r {
                let $answer = $crate::intercept::gl::entry::vendor::real_call!($name, ($($t),*) -> $r, $($p),*);
                $note;
                $answer
            }
        )*
    };
}

pub(crate) use noted_calls;
