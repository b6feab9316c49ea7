//! Instances: the next layer's functions for each.

use crate::intercept::vk::layer::negotiate;
use ash::vk;
use std::collections::HashMap;
use std::ffi::c_void;
use std::sync::{Arc, PoisonError, RwLock};

/// An instance of the program.
pub struct Instance {
    /// The next layer's `vkGetInstanceProcAddr`.
    pub get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    /// The next layer's functions.
    pub functions: ash::Instance,
    /// Those of `VK_KHR_surface`; they may be called only where the program enabled it.
    pub surface: ash::khr::surface::InstanceFn,
}

static INSTANCES: RwLock<Option<HashMap<usize, Arc<Instance>>>> = RwLock::new(None);

/// What all objects that are dispatched by the same table have in common: the table's address.
///
/// # Safety
/// `object` must be a live dispatchable Vulkan object.
pub unsafe fn dispatch_key(object: u64) -> usize {
    // SAFETY: the loader keeps its table's address in the first word of each such object.
    unsafe { *(object as *const usize) }
}

/// The instance that an instance or a physical device belongs to.
pub fn get(handle: impl vk::Handle) -> Option<Arc<Instance>> {
    let object = handle.as_raw();
    if object == 0 {
        return None;
    }
    // SAFETY: the program passed a live handle to Vulkan.
    let key = unsafe { dispatch_key(object) };
    INSTANCES.read().unwrap_or_else(PoisonError::into_inner).as_ref()?.get(&key).cloned()
}

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
        let link = info.as_ref().and_then(|info| negotiate::take_instance_link(info.p_next));
        let Some(link) = link else { return vk::Result::ERROR_INITIALIZATION_FAILED };
        let next = link.get_instance_proc_addr;
        let Some(create) = next(vk::Instance::null(), c"vkCreateInstance".as_ptr()) else {
            return vk::Result::ERROR_INITIALIZATION_FAILED;
        };
        let create: vk::PFN_vkCreateInstance = std::mem::transmute(create);
        let result = create(info, allocator, handle);
        if result == vk::Result::SUCCESS {
            let made = *handle;
            let find = |name: &std::ffi::CStr| address(next(made, name.as_ptr()));
            let state = Instance {
                get_instance_proc_addr: next,
                functions: ash::Instance::load_with(find, made),
                surface: ash::khr::surface::InstanceFn::load(find),
            };
            let key = dispatch_key(vk::Handle::as_raw(made));
            let mut instances = INSTANCES.write().unwrap_or_else(PoisonError::into_inner);
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
    let state = INSTANCES.write().unwrap_or_else(PoisonError::into_inner).as_mut().and_then(|all| all.remove(&key));
    if let Some(state) = state {
        // SAFETY: the program's own call with its arguments.
        unsafe { (state.functions.fp_v1_0().destroy_instance)(handle, allocator) };
    }
}

/// A function's address in the form in which tables are filled.
pub fn address(function: vk::PFN_vkVoidFunction) -> *const c_void {
    function.map_or(std::ptr::null(), |function| function as *const c_void)
}
