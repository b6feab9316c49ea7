//! The table of all hooks of a device.

use crate::intercept::vk::commands::passes::{dynamic_rendering, framebuffers, render_passes};
use crate::intercept::vk::commands::{
    barriers_and_clears, bound_state, buffer_copies, conditional_render, copies, dispatches, draws, recording,
    unsupported,
};
use crate::intercept::vk::descriptors::{push_descriptors, sets};
use crate::intercept::vk::layer::device;
use crate::intercept::vk::offscreen::images;
use crate::intercept::vk::pipelines::{compute, layouts, program_pipelines};
use crate::intercept::vk::queries::hooks as query_hooks;
use crate::intercept::vk::submit::{host_memory, queue};
use crate::intercept::vk::swapchain::{create, present};
use std::collections::HashMap;
use std::ffi::CStr;
use std::sync::OnceLock;

/// Hooks that are also needed without views.
pub const ALWAYS: [&CStr; 1] = [c"vkCreateImageView"];

/// Returns Cupola's hook of a device function with this name, if it is needed with and without
/// views.
pub fn of_device(name: &CStr) -> Option<*const ()> {
    Some(match name.to_bytes() {
        b"vkDestroyDevice" => device::destroy as *const (),
        b"vkGetDeviceQueue" => device::queue as *const (),
        b"vkGetDeviceQueue2" => device::queue2 as *const (),
        b"vkCreateSwapchainKHR" => create::create as *const (),
        b"vkDestroySwapchainKHR" => create::destroy as *const (),
        b"vkGetSwapchainImagesKHR" => create::images as *const (),
        b"vkQueuePresentKHR" => present::present as *const (),
        _ => return None,
    })
}

/// Returns Cupola's hook of a device function with this name, if it is needed for views.
pub fn find(name: &CStr) -> Option<*const ()> {
    table().get(name).map(|address| *address as *const ())
}

/// All hooks of device functions that are needed for views, by the functions' names.
fn table() -> &'static HashMap<&'static CStr, usize> {
    static TABLE: OnceLock<HashMap<&'static CStr, usize>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let files = [
            barriers_and_clears::HOOKS,
            bound_state::HOOKS,
            conditional_render::HOOKS,
            buffer_copies::HOOKS,
            copies::HOOKS,
            dispatches::HOOKS,
            draws::hooks::HOOKS,
            dynamic_rendering::HOOKS,
            framebuffers::HOOKS,
            render_passes::HOOKS,
            recording::HOOKS,
            unsupported::HOOKS,
            push_descriptors::HOOKS,
            sets::HOOKS,
            images::HOOKS,
            compute::HOOKS,
            layouts::HOOKS,
            program_pipelines::HOOKS,
            query_hooks::HOOKS,
            host_memory::HOOKS,
            queue::HOOKS,
        ];
        let hooks = files.into_iter().flatten();
        hooks.flat_map(|hook| hook.names.iter().map(|name| (*name, hook.address as usize))).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::table;

    /// A function is hooked only if Cupola must see its calls. `cupola-lab structure` reads this
    /// number.
    #[test]
    fn the_number_of_hooked_functions_is_known() {
        assert_eq!(table().len(), 178);
    }
}
