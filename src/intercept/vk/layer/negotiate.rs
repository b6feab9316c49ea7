//! What the loader and a layer say to each other (Vulkan-Loader, "Loader and Layer Interface", version 2).

use crate::intercept::vk::layer::{device, instance};
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
/// The version of the interface that has this negotiation.
const VERSION: u32 = 2;

/// `VK_LAYER_LINK_INFO`: the structure tells the next layer's functions.
const LINK_INFO: i32 = 0;
/// `VK_LOADER_DATA_CALLBACK`: the structure has the loader's function for objects that a layer makes.
const DATA_CALLBACK: i32 = 1;

/// `VkLayerInstanceCreateInfo` and `VkLayerDeviceCreateInfo`, which have the same form.
#[repr(C)]
struct LayerCreateInfo {
    kind: vk::StructureType,
    next: *const c_void,
    function: i32,
    /// The link, or the callback.
    content: *mut c_void,
}

/// Bytes of `VkLayerDeviceCreateInfo`.
pub const LAYER_INFO_LENGTH: usize = size_of::<LayerCreateInfo>();

/// `VkLayerInstanceLink`.
#[repr(C)]
pub struct InstanceLink {
    next: *mut c_void,
    /// The next layer's `vkGetInstanceProcAddr`.
    pub get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    get_physical_device_proc_addr: Option<vk::PFN_vkGetInstanceProcAddr>,
}

/// `VkLayerDeviceLink`.
#[repr(C)]
pub struct DeviceLink {
    next: *mut c_void,
    /// The next layer's `vkGetInstanceProcAddr`.
    pub get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    /// The next layer's `vkGetDeviceProcAddr`.
    pub get_device_proc_addr: vk::PFN_vkGetDeviceProcAddr,
}

/// `PFN_vkSetDeviceLoaderData`: makes an object of a layer one that can be dispatched.
pub type SetDeviceLoaderData = unsafe extern "system" fn(vk::Device, *mut c_void) -> vk::Result;

/// The structure in a chain that the loader put there for layers.
///
/// # Safety
/// `chain` must be a chain of Vulkan structures.
unsafe fn layer_info(chain: *const c_void, kind: vk::StructureType, function: i32) -> Option<*mut LayerCreateInfo> {
    let mut at = chain.cast::<LayerCreateInfo>();
    while !at.is_null() {
        // SAFETY: each structure begins with its kind and the next one; ours has the content, too.
        unsafe {
            if (*at).kind == kind && (*at).function == function {
                return Some(at.cast_mut());
            }
            at = (*at).next.cast();
        }
    }
    None
}

/// Takes the link of this layer out of an instance's chain, so that the next layer finds its own.
///
/// # Safety
/// `chain` must be the chain of the loader's call.
pub unsafe fn take_instance_link(chain: *const c_void) -> Option<InstanceLink> {
    // SAFETY: as promised; the loader's structures are made for this change.
    unsafe {
        let info = layer_info(chain, vk::StructureType::LOADER_INSTANCE_CREATE_INFO, LINK_INFO)?;
        let link = (*info).content.cast::<InstanceLink>();
        let link = link.as_ref()?;
        (*info).content = link.next;
        Some(std::ptr::read(link))
    }
}

/// Takes the link of this layer out of a device's chain, with the loader's callback.
///
/// # Safety
/// As for [`take_instance_link`].
pub unsafe fn take_device_link(chain: *const c_void) -> Option<(DeviceLink, Option<SetDeviceLoaderData>)> {
    let kind = vk::StructureType::LOADER_DEVICE_CREATE_INFO;
    // SAFETY: as above; the callback's content is a function's address, which may be null.
    unsafe {
        let info = layer_info(chain, kind, LINK_INFO)?;
        let link = (*info).content.cast::<DeviceLink>();
        let link = link.as_ref()?;
        (*info).content = link.next;
        let callback = layer_info(chain, kind, DATA_CALLBACK).map(|info| (*info).content);
        let callback = callback.and_then(|address| std::mem::transmute::<_, Option<SetDeviceLoaderData>>(address));
        Some((std::ptr::read(link), callback))
    }
}

/// The entry that the loader looks for in a layer's library.
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

/// Our function of this name, as an address.
fn own(name: &CStr) -> vk::PFN_vkVoidFunction {
    let address = match name.to_bytes() {
        b"vkGetInstanceProcAddr" => get_instance_proc_addr as *const (),
        b"vkCreateInstance" => instance::create as *const (),
        b"vkDestroyInstance" => instance::destroy as *const (),
        b"vkCreateDevice" => device::create as *const (),
        _ => return own_of_device(name),
    };
    // SAFETY: the address of a function; who asks for it knows its signature.
    Some(unsafe { std::mem::transmute::<*const (), unsafe extern "system" fn()>(address) })
}

fn own_of_device(name: &CStr) -> vk::PFN_vkVoidFunction {
    let address = match name.to_bytes() {
        b"vkGetDeviceProcAddr" => get_device_proc_addr as *const (),
        name => crate::intercept::vk::hook(name)?,
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
    let Some(state) = instance::get(handle) else { return ours };
    // SAFETY: the program's own call, passed on.
    let real = unsafe { (state.get_instance_proc_addr)(handle, name) };
    // A function that the driver does not have must not appear to be there.
    real.and(ours).or(real)
}

unsafe extern "system" fn get_device_proc_addr(
    handle: vk::Device,
    name: *const std::ffi::c_char,
) -> vk::PFN_vkVoidFunction {
    let state = device::get(handle)?;
    // SAFETY: the program's own call, passed on.
    let real = unsafe { (state.get_device_proc_addr)(handle, name) }?;
    if !state.active {
        // SAFETY: a NUL-terminated name.
        let destroys = unsafe { CStr::from_ptr(name) } == c"vkDestroyDevice";
        if !destroys {
            return Some(real);
        }
    }
    // SAFETY: as above.
    let name = unsafe { CStr::from_ptr(name) };
    let of_views = || {
        crate::intercept::vk::layer::table::find(name)
            .filter(|_| state.corrects || crate::intercept::vk::layer::table::ALWAYS.contains(&name))
    };
    // SAFETY: the address of a function; who asks for it knows its signature.
    let of_views =
        || of_views().map(|address| unsafe { std::mem::transmute::<*const (), unsafe extern "system" fn()>(address) });
    own_of_device(name).or_else(of_views).or(Some(real))
}
