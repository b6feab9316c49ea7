//! `vkNegotiateLoaderLayerInterfaceVersion` and Cupola's `Get…ProcAddr` (Vulkan-Loader, "Loader and
//! Layer Interface", version 2).

use crate::intercept::vk::layer::{device, instance, table};
use crate::intercept::vk::state::device as devices;
use crate::intercept::vk::state::driver::instance as instances;
use crate::intercept::vk::swapchain::surfaces;
use ash::vk;
use std::ffi::{CStr, c_void};

/// `VkNegotiateLayerInterface`.
#[repr(C)]
pub struct NegotiateLayerInterface {
    kind: i32,
    next: *mut c_void,
    version: u32,
    get_instance_proc_addr: Option<vk::PFN_vkGetInstanceProcAddr>,
    get_device_proc_addr: Option<vk::PFN_vkGetDeviceProcAddr>,
    get_physical_device_proc_addr: Option<vk::PFN_vkGetInstanceProcAddr>,
}

/// `LAYER_NEGOTIATE_INTERFACE_STRUCT`.
const INTERFACE: i32 = 1;
/// Version of the interface from which on this negotiation exists.
const VERSION: u32 = 2;

/// Entry point that the loader looks for in a layer's library.
///
/// # Safety
/// Called by the Vulkan loader with its structure.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn vkNegotiateLoaderLayerInterfaceVersion(
    interface: *mut NegotiateLayerInterface,
) -> vk::Result {
    // SAFETY: the loader's structure, or null.
    let Some(interface) = (unsafe { interface.as_mut() }) else { return vk::Result::ERROR_INITIALIZATION_FAILED };
    if interface.kind != INTERFACE || interface.version < VERSION {
        return vk::Result::ERROR_INITIALIZATION_FAILED;
    }
    interface.version = VERSION;
    interface.get_instance_proc_addr = Some(get_instance_proc_addr);
    interface.get_device_proc_addr = Some(get_device_proc_addr);
    interface.get_physical_device_proc_addr = None;
    vk::Result::SUCCESS
}

/// Returns the address of Cupola's function with this name.
fn own(name: &CStr) -> vk::PFN_vkVoidFunction {
    let address = match name.to_bytes() {
        b"vkGetInstanceProcAddr" => get_instance_proc_addr as *const (),
        b"vkCreateInstance" => instance::create as *const (),
        b"vkDestroyInstance" => instance::destroy as *const (),
        b"vkCreateDevice" => device::create as *const (),
        _ => match surfaces::find(name) {
            Some(address) => address,
            None => return own_of_device(name),
        },
    };
    // SAFETY: the address of a function; the caller knows its signature.
    Some(unsafe { std::mem::transmute::<*const (), unsafe extern "system" fn()>(address) })
}

fn own_of_device(name: &CStr) -> vk::PFN_vkVoidFunction {
    let address = match name.to_bytes() {
        b"vkGetDeviceProcAddr" => get_device_proc_addr as *const (),
        _ => table::of_device(name)?,
    };
    // SAFETY: as above.
    Some(unsafe { std::mem::transmute::<*const (), unsafe extern "system" fn()>(address) })
}

unsafe extern "system" fn get_instance_proc_addr(
    handle: vk::Instance,
    name: *const std::ffi::c_char,
) -> vk::PFN_vkVoidFunction {
    // SAFETY: a NUL-terminated name, as Vulkan demands.
    let text = unsafe { CStr::from_ptr(name) };
    let ours = own(text);
    let Some(state) = instances::get(handle) else { return ours };
    // SAFETY: the program's own call, passed on.
    let real = unsafe { (state.get_instance_proc_addr)(handle, name) };
    // A function that the driver does not have must not appear to exist.
    real.and(ours).or(real)
}

unsafe extern "system" fn get_device_proc_addr(
    handle: vk::Device,
    name: *const std::ffi::c_char,
) -> vk::PFN_vkVoidFunction {
    let state = devices::get(handle)?;
    // SAFETY: the program's own call, passed on.
    let real = unsafe { (state.driver.get_device_proc_addr)(handle, name) }?;
    if !state.role.active {
        // SAFETY: a NUL-terminated name.
        let destroys = unsafe { CStr::from_ptr(name) } == c"vkDestroyDevice";
        if !destroys {
            return Some(real);
        }
    }
    // SAFETY: as above.
    let name = unsafe { CStr::from_ptr(name) };
    let of_views = || table::find(name).filter(|_| state.role.corrects || table::ALWAYS.contains(&name));
    // SAFETY: the address of a function; the caller knows its signature.
    let of_views =
        || of_views().map(|address| unsafe { std::mem::transmute::<*const (), unsafe extern "system" fn()>(address) });
    own_of_device(name).or_else(of_views).or(Some(real))
}
