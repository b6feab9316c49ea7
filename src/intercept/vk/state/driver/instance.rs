//! Instances: the next layer's functions for each.

use crate::intercept::vk::state::driver::xcb::XcbWindow;
use crate::lock::SharedLock;
use ash::vk;
use std::collections::HashMap;
use std::ffi::c_void;
use std::sync::{Arc, Mutex, RwLock};

/// An instance of the program.
pub struct Instance {
    /// The next layer's `vkGetInstanceProcAddr`.
    pub(in crate::intercept::vk) get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    /// The next layer's functions.
    pub(in crate::intercept::vk) functions: ash::Instance,
    /// The functions of `VK_KHR_surface`. They may be called only if the program enabled it.
    pub(in crate::intercept::vk) surface: ash::khr::surface::InstanceFn,
    /// Those of `VK_KHR_get_surface_capabilities2`, likewise.
    pub(in crate::intercept::vk) surface2: ash::khr::get_surface_capabilities2::InstanceFn,
    /// Those of `VK_KHR_xlib_surface`, likewise.
    pub(in crate::intercept::vk) xlib: ash::khr::xlib_surface::InstanceFn,
    /// Those of `VK_KHR_xcb_surface`, likewise.
    pub(in crate::intercept::vk) xcb: ash::khr::xcb_surface::InstanceFn,
    /// Windows of X11 that get a size (`swapchain`).
    pub(in crate::intercept::vk) surfaces: Mutex<HashMap<vk::SurfaceKHR, Surface>>,
}

/// The window of a surface.
pub(in crate::intercept::vk) struct Surface {
    pub(in crate::intercept::vk) window: XcbWindow,
    /// Number of times that its size was changed.
    pub(in crate::intercept::vk) resized: u32,
}

pub(in crate::intercept::vk) static INSTANCES: RwLock<Option<HashMap<usize, Arc<Instance>>>> = RwLock::new(None);

/// Returns the address of the dispatch table, which all objects of an instance or a device share.
///
/// # Safety
/// `object` must be a live dispatchable Vulkan object.
pub unsafe fn dispatch_key(object: u64) -> usize {
    // SAFETY: the loader stores the address of its table in the first word of each such object.
    unsafe { *(object as *const usize) }
}

/// Returns the instance that an instance or a physical device belongs to.
pub fn get(handle: impl vk::Handle) -> Option<Arc<Instance>> {
    let object = handle.as_raw();
    if object == 0 {
        return None;
    }
    // SAFETY: the program passed a live handle to Vulkan.
    let key = unsafe { dispatch_key(object) };
    INSTANCES.reading().as_ref()?.get(&key).cloned()
}

/// Returns a function's address in the form for tables of functions.
pub fn address(function: vk::PFN_vkVoidFunction) -> *const c_void {
    function.map_or(std::ptr::null(), |function| function as *const c_void)
}
