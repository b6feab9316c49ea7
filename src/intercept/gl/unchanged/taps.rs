//! Functions for the calls that have no hook, so that each is noted.
//!
//! The rows come from the registry (`build/gl_taps.rs`), vendors' calls included; what only answers is left to the driver.

use super::call::{Call, Word};
use super::calls::{self, Kind};
use super::unknown;
use crate::intercept::gl::registry;
use std::collections::HashMap;
use std::ffi::{c_char, c_void};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicPtr, Ordering};

/// Notes a call of the context `$ctx`. Unsafe: the arguments must be the program's.
macro_rules! noted {
    ($ctx:ident, $name:literal, $($p:ident: $t:ty),*) => {{
        use $crate::intercept::gl::unchanged;
        const CALL: unchanged::call::Call = unchanged::call::Call::new(
            $name,
            [$(<$t as unchanged::call::Word>::POINTS),*],
            [$(<$t as unchanged::call::Word>::SIZE),*],
        );
        if CALL.counts() {
            unchanged::noting::note($ctx, &CALL, &[$(unchanged::call::Word::word($p)),*]);
        }
    }};
}
pub(in crate::intercept::gl) use noted;

/// Our function for a call without a hook, which the driver answers with `real`.
pub fn find(name: &str, real: *const c_void) -> Option<*const ()> {
    static TABLE: OnceLock<HashMap<&'static str, usize>> = OnceLock::new();
    if !name.starts_with("gl") || name.starts_with("glX") || calls::kind(name, &[]) == Kind::Nothing {
        return None;
    }
    let table = TABLE.get_or_init(|| TAPS.iter().enumerate().map(|(slot, tap)| (tap.0, slot)).collect());
    let Some(slot) = table.get(name) else {
        return unknown::noted(real);
    };
    // Two vendors may have functions of their own; only the first's go through ours.
    let stored =
        REAL[*slot].compare_exchange(std::ptr::null_mut(), real.cast_mut(), Ordering::AcqRel, Ordering::Acquire);
    if stored.is_err_and(|other| other.cast_const() != real) {
        unknown::suspect();
        return None;
    }
    Some(TAPS[*slot].1.0)
}

/// Notes a call without a hook.
///
/// # Safety
/// As of [`super::noting::note`].
unsafe fn before(call: &Call, words: &[u64]) {
    if let Some(ctx) = registry::current().filter(|ctx| !ctx.switched_off) {
        // SAFETY: as promised.
        unsafe { super::noting::note(ctx, call, words) };
    }
}

/// A function of any signature.
#[derive(Clone, Copy)]
struct Function(*const ());

// SAFETY: an address of a function never changes and may be read from any thread.
unsafe impl Sync for Function {}

macro_rules! taps {
    ($count:literal $( $name:literal $function:ident $slot:literal ( $($p:ident: $t:ty),* ) -> $r:ty = $kind:expr, [$($noted:ident),*]; )*) => {
        /// The driver's functions, once the program has asked for them.
        static REAL: [AtomicPtr<c_void>; $count] = [const { AtomicPtr::new(std::ptr::null_mut()) }; $count];

        $(
            unsafe extern "system" fn $function($($p: $t),*) -> $r {
                const CALL: Call = Call::of_kind($name, $kind, [$(<$t as Word>::SIZE),*]);
                // SAFETY: the program's own call; it got this function in place of the driver's, which has this signature.
                unsafe {
                    before(&CALL, &[$(Word::word($noted)),*]);
                    let real: unsafe extern "system" fn($($t),*) -> $r =
                        std::mem::transmute(REAL[$slot].load(Ordering::Relaxed));
                    real($($p),*)
                }
            }
        )*

        static TAPS: [(&str, Function); $count] = [$( ($name, Function($function as *const ())) ),*];
    };
}

include!(concat!(env!("OUT_DIR"), "/gl_taps.rs"));

#[cfg(test)]
mod tests {
    use super::TAPS;
    use crate::intercept::gl::hook;

    #[test]
    fn calls_without_a_hook_have_a_tap() {
        for name in ["glLightfv", "glLineWidth", "glTexImage2D", "glGenerateMipmap", "glDispatchCompute", "glFogfv"] {
            assert!(hook::find(name).is_some() || TAPS.iter().any(|tap| tap.0 == name), "{name}");
        }
        // Vendors' calls that are no aliases.
        for name in
            ["glProgramStringARB", "glMultiTexImage2DEXT", "glEGLImageTargetTexture2DOES", "glTexFilterFuncSGIS"]
        {
            assert!(TAPS.iter().any(|tap| tap.0 == name), "{name}");
        }
        for name in ["glGetIntegerv", "glIsEnabled"] {
            assert!(TAPS.iter().all(|tap| tap.0 != name), "{name}");
        }
        assert!(TAPS.len() > 1500, "{}", TAPS.len());
    }
}
