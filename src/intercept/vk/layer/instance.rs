//! Life of an instance: `vkCreateInstance` and `vkDestroyInstance`.

use crate::intercept::vk::layer::{chain_links, present_barrier};
use crate::intercept::vk::state::driver::instance::{INSTANCES, Instance, address, dispatch_key};
use crate::lock::SharedLock;
use ash::vk;
use std::collections::HashMap;
use std::sync::Arc;

/// `vkCreateInstance`.
///
/// # Safety
/// Called by the Vulkan loader with the program's arguments.
pub unsafe extern "system" fn create(
    info: *const vk::InstanceCreateInfo<'_>,
    allocator: *const vk::AllocationCallbacks<'_>,
    handle: *mut vk::Instance,
) -> vk::Result {
    // SAFETY: the loader's chain, and the program's own call with its arguments.
    unsafe {
        let link = info.as_ref().and_then(|info| chain_links::take_instance_link(info.p_next));
        let Some(link) = link else { return vk::Result::ERROR_INITIALIZATION_FAILED };
        let next = link.get_instance_proc_addr;
        let Some(create) = next(vk::Instance::null(), c"vkCreateInstance".as_ptr()) else {
            return vk::Result::ERROR_INITIALIZATION_FAILED;
        };
        let create: vk::PFN_vkCreateInstance = std::mem::transmute(create);
        let extended =
            info.as_ref().filter(|_| present_barrier::wanted()).and_then(|info| present_barrier::instance(info));
        let result = create(extended.as_ref().map_or(info, |(info, _)| &raw const *info), allocator, handle);
        if result == vk::Result::SUCCESS {
            let made = *handle;
            let find = |name: &std::ffi::CStr| address(next(made, name.as_ptr()));
            let state = Instance {
                get_instance_proc_addr: next,
                functions: ash::Instance::load_with(find, made),
                surface: ash::khr::surface::InstanceFn::load(find),
                surface2: ash::khr::get_surface_capabilities2::InstanceFn::load(find),
                xlib: ash::khr::xlib_surface::InstanceFn::load(find),
                xcb: ash::khr::xcb_surface::InstanceFn::load(find),
                surfaces: Default::default(),
            };
            let key = dispatch_key(vk::Handle::as_raw(made));
            let mut instances = INSTANCES.writing();
            instances.get_or_insert_with(HashMap::new).insert(key, Arc::new(state));
        }
        result
    }
}

/// `vkDestroyInstance`.
///
/// # Safety
/// Called by the Vulkan loader with the program's arguments.
pub unsafe extern "system" fn destroy(handle: vk::Instance, allocator: *const vk::AllocationCallbacks<'_>) {
    if handle == vk::Instance::null() {
        return;
    }
    // SAFETY: a live handle.
    let key = unsafe { dispatch_key(vk::Handle::as_raw(handle)) };
    let state = INSTANCES.writing().as_mut().and_then(|all| all.remove(&key));
    if let Some(state) = state {
        // SAFETY: the program's own call with its arguments.
        unsafe { (state.functions.fp_v1_0().destroy_instance)(handle, allocator) };
    }
}
