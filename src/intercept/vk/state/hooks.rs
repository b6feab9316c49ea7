//! Definition of hooks: functions that answer Vulkan entry points.

use std::ffi::CStr;

/// A function of Vulkan and the function of Cupola that answers it.
pub struct Hook {
    /// The names of the Vulkan function.
    pub names: &'static [&'static CStr],
    /// Cupola's function, with the signature of the Vulkan function.
    pub address: *const (),
}

// SAFETY: the address of a function never changes and may be read from any thread.
unsafe impl Sync for Hook {}

/// Defines hooks, and the table `HOOKS` of them. Each hook has the name of an entry of
/// [`entry_points`](crate::intercept::vk::state::driver::entry_points).
///
/// Each body gets the device (`$device`) and the next layer's function (`$next`). After a panic the
/// program is shown flat from then on, and the call goes to the next layer.
macro_rules! hooks {
    ($( $method:ident = ($first:ident : $ft:ty $(, $p:ident : $t:ty)*) $(-> $r:ty)? { |$device:ident, $next:ident| $body:expr } )*) => {
        $(
            // Some bodies need no unsafe call. The unsafe block below is for all of them.
            #[allow(unused_unsafe)]
            unsafe extern "system" fn $method($first: $ft $(, $p: $t)*) $(-> $r)? {
                let Some($device) = $crate::intercept::vk::state::device::get($first) else { return Default::default() };
                let Some($next) = $device.next.$method else { return Default::default() };
                // SAFETY: the bodies call functions of the next layer, with the program's arguments
                // or with objects of Cupola.
                match $crate::fence::guard(|| unsafe { $body }) {
                    Some(answer) => answer,
                    None => {
                        $device.show_flat("a failure of Cupola's");
                        // SAFETY: the program's own call, passed on with its own arguments.
                        unsafe { $next($first $(, $p)*) }
                    }
                }
            }
        )*

        /// The hooks of this file.
        pub static HOOKS: &[$crate::intercept::vk::state::hooks::Hook] = &[
            $( $crate::intercept::vk::state::hooks::Hook {
                names: $crate::intercept::vk::state::driver::entry_points::names::$method,
                address: $method as *const (),
            }, )*
        ];
    };
}
pub(crate) use hooks;
