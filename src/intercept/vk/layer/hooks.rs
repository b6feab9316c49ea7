//! Definition of hooks: functions that answer Vulkan entry points.

use std::ffi::CStr;

/// A function of Vulkan and the function of ours that answers it.
pub struct Hook {
    /// The names that it goes by.
    pub names: &'static [&'static CStr],
    /// Our function, with the signature that Vulkan gives it.
    pub address: *const (),
}

// SAFETY: an address of a function never changes and may be read from any thread.
unsafe impl Sync for Hook {}

/// Defines hooks, the table `HOOKS` of them, and `Next`, the next layer's functions of the same names, which a
/// device has as its field `$table`.
///
/// Each body gets the device (`$device`) and the next layer's function (`$next`). After a panic the program is
/// shown flat from then on, and the call goes to the next layer.
macro_rules! hooks {
    ($table:ident; $( [$($name:literal),+] $method:ident : $pfn:ty = ($first:ident : $ft:ty $(, $p:ident : $t:ty)*) $(-> $r:ty)? { |$device:ident, $next:ident| $body:expr } )*) => {
        /// The next layer's functions.
        pub struct Next { $( $method: Option<$pfn>, )* }

        impl Next {
            /// # Safety
            /// `find` must give a device's functions.
            pub unsafe fn load(find: &dyn Fn(&std::ffi::CStr) -> ash::vk::PFN_vkVoidFunction) -> Self {
                // SAFETY: as promised; a function has the type that Vulkan gives to its name.
                unsafe {
                    Self { $( $method: [$($name),+].into_iter().find_map(find).map(|f| std::mem::transmute::<unsafe extern "system" fn(), $pfn>(f)), )* }
                }
            }
        }

        $(
            // Some bodies need no unsafe call; the block below serves them all.
            #[allow(unused_unsafe)]
            unsafe extern "system" fn $method($first: $ft $(, $p: $t)*) $(-> $r)? {
                let Some($device) = $crate::intercept::vk::layer::device::get($first) else { return Default::default() };
                let Some($next) = $device.next.$table.$method else { return Default::default() };
                // SAFETY: what the bodies call are the next layer's functions, with the program's arguments or with
                // our own objects.
                match $crate::fence::guard(|| unsafe { $body }) {
                    Some(answer) => answer,
                    None => {
                        $device.give_up("a failure of Cupola's");
                        // SAFETY: the program's own call, passed on with its own arguments.
                        unsafe { $next($first $(, $p)*) }
                    }
                }
            }
        )*

        /// The hooks of this file.
        pub static HOOKS: &[$crate::intercept::vk::layer::hooks::Hook] = &[
            $( $crate::intercept::vk::layer::hooks::Hook { names: &[$($name),+], address: $method as *const () }, )*
        ];
    };
}
pub(crate) use hooks;
