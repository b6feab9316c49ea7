//! How a hook is written, and how a name finds its hook.

use ash::vk;
use std::collections::HashMap;
use std::ffi::CStr;
use std::sync::OnceLock;

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
                let Some($device) = $crate::intercept::vk::device::get($first) else { return Default::default() };
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
        pub static HOOKS: &[$crate::intercept::vk::hook::Hook] = &[
            $( $crate::intercept::vk::hook::Hook { names: &[$($name),+], address: $method as *const () }, )*
        ];
    };
}
pub(crate) use hooks;

/// The next layer's functions that are called by hooks for the views.
pub struct NextLayer {
    /// Command buffers.
    pub recording: super::recording::Next,
    /// Bound pipelines, descriptors, viewports.
    pub state: super::state::Next,
    /// Draws.
    pub draws: super::draws::Next,
    /// Render passes and framebuffers.
    pub framebuffers: super::framebuffers::Next,
    /// Their begin and end.
    pub passes: super::passes::Next,
    /// Pipelines.
    pub pipelines: super::pipelines::Next,
    /// Pipeline layouts and shaders.
    pub layouts: super::layouts::Next,
    /// Descriptors.
    pub descriptors: super::descriptors::Next,
    /// Descriptors that are pushed.
    pub pushed: super::pushed::Next,
    /// Buffers and memory.
    pub memory: super::memory::Next,
    /// Images.
    pub images: super::images::Next,
    /// Barriers and clears.
    pub transfers: super::transfers::Next,
    /// Copies between images.
    pub copies: super::copies::Next,
    /// Conditions.
    pub conditional: super::conditional::Next,
    /// Queries.
    pub queries: super::queries::Next,
    /// Submissions.
    pub submit: super::submit::Next,
}

impl NextLayer {
    /// # Safety
    /// `find` must give a device's functions.
    pub unsafe fn load(find: &dyn Fn(&CStr) -> vk::PFN_vkVoidFunction) -> Self {
        // SAFETY: as promised.
        unsafe {
            Self {
                recording: super::recording::Next::load(find),
                state: super::state::Next::load(find),
                draws: super::draws::Next::load(find),
                framebuffers: super::framebuffers::Next::load(find),
                passes: super::passes::Next::load(find),
                pipelines: super::pipelines::Next::load(find),
                layouts: super::layouts::Next::load(find),
                descriptors: super::descriptors::Next::load(find),
                pushed: super::pushed::Next::load(find),
                memory: super::memory::Next::load(find),
                images: super::images::Next::load(find),
                transfers: super::transfers::Next::load(find),
                copies: super::copies::Next::load(find),
                conditional: super::conditional::Next::load(find),
                queries: super::queries::Next::load(find),
                submit: super::submit::Next::load(find),
            }
        }
    }
}

/// Hooks that are needed without views, too.
pub const ALWAYS: [&CStr; 1] = [c"vkCreateImageView"];

/// Our function for a device's function of this name that is needed for views.
pub fn find(name: &CStr) -> Option<*const ()> {
    static TABLE: OnceLock<HashMap<&'static CStr, usize>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        let files = [
            super::recording::HOOKS,
            super::state::HOOKS,
            super::draws::HOOKS,
            super::framebuffers::HOOKS,
            super::passes::HOOKS,
            super::pipelines::HOOKS,
            super::layouts::HOOKS,
            super::descriptors::HOOKS,
            super::pushed::HOOKS,
            super::memory::HOOKS,
            super::images::HOOKS,
            super::transfers::HOOKS,
            super::copies::HOOKS,
            super::conditional::HOOKS,
            super::queries::HOOKS,
            super::submit::HOOKS,
        ];
        let hooks = files.into_iter().flatten();
        hooks.flat_map(|hook| hook.names.iter().map(|name| (*name, hook.address as usize))).collect()
    });
    table.get(name).map(|address| *address as *const ())
}
