//! Definition of hooks: functions that answer OpenGL entry points.

/// A name of the API and the function of Cupola that answers it.
pub struct Hook {
    /// The entry point's core name.
    pub name: &'static str,
    /// Cupola's function, with the entry point's own signature.
    pub address: *const (),
}

// SAFETY: an address of a function never changes and may be read from any thread.
unsafe impl Sync for Hook {}

/// Defines hooks and the table `HOOKS` of them.
///
/// Each body gets the current context (`$ctx`) and the driver's table (`$gl`). These calls go
/// straight to the driver:
///
/// * calls without a context of Cupola;
/// * calls after a panic, which switches the context off (interception fails open);
/// * calls once the process ends;
/// * commands that the profile does not have;
/// * calls between Begin and End of a draw of Cupola. The driver reports that they are not allowed
///   there. `between;` marks hooks of commands that are allowed there.
macro_rules! hooks {
    (between; $($hooks:tt)*) => {
        $crate::intercept::gl::context::hooks::hooks! { @between true; $($hooks)* }
    };
    (@between $between:literal; $( $name:literal $method:ident ( $($p:ident : $t:ty),* ) $(-> $r:ty)? = |$ctx:ident, $gl:ident| $body:expr; )*) => {
        $(
            // Some bodies need no unsafe call; the block below serves them all.
            #[allow(unused_unsafe)]
            unsafe extern "system" fn $method($($p: $t),*) $(-> $r)? {
                let Some($ctx) = $crate::intercept::gl::context::current::current() else {
                    // SAFETY: the program's own call, passed on with its own arguments.
                    return unsafe { $crate::intercept::gl::context::current::driver().$method($($p),*) };
                };
                let $gl = $ctx.driver.gl;
                const OUTSIDE: $crate::backend::gl::driver::api::Outside = $crate::backend::gl::driver::api::Outside::of($name);
                if $ctx.switched_off
                    || $crate::intercept::process::ending::of_process()
                    || $ctx.driver.profile.is_outside(OUTSIDE)
                    || (!$between && $ctx.compat.refuses($gl))
                {
                    // SAFETY: as above.
                    return unsafe { $gl.$method($($p),*) };
                }
                $crate::intercept::process::call_sum::add_call!($name $(, $p)*);
                // SAFETY: the bodies call the driver's functions, with the program's arguments or
                // with objects of Cupola, on the thread where this context is current.
                match $crate::fence::guard(|| unsafe { $body }) {
                    Some(answer) => answer,
                    None => {
                        $crate::intercept::gl::context::current::after_panic($name);
                        // SAFETY: as above.
                        unsafe { $gl.$method($($p),*) }
                    }
                }
            }
        )*
        /// The hooks of this file.
        pub static HOOKS: &[$crate::intercept::gl::context::hooks::Hook] = &[
            $( $crate::intercept::gl::context::hooks::Hook { name: $name, address: $method as *const () }, )*
        ];
    };
    ($($hooks:tt)*) => {
        $crate::intercept::gl::context::hooks::hooks! { @between false; $($hooks)* }
    };
}

pub(crate) use hooks;
