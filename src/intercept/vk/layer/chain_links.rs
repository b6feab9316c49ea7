//! The structures in creation chains by which the loader gives a layer the next layer's functions
//! (Vulkan-Loader, "Loader and Layer Interface", version 2).

use crate::intercept::vk::state::driver::SetDeviceLoaderData;
use ash::vk;
use std::ffi::c_void;

/// `VK_LAYER_LINK_INFO`: the structure contains the next layer's functions.
const LINK_INFO: i32 = 0;

/// `VK_LOADER_DATA_CALLBACK`: the structure contains the loader's function for objects that a layer
/// creates.
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

/// Size of `VkLayerDeviceCreateInfo` in bytes.
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

/// Returns the structure that the loader put into a chain for layers.
///
/// # Safety
/// `chain` must be a chain of Vulkan structures.
unsafe fn layer_info(chain: *const c_void, kind: vk::StructureType, function: i32) -> Option<*mut LayerCreateInfo> {
    let mut at = chain.cast::<LayerCreateInfo>();
    while !at.is_null() {
        // SAFETY: each structure begins with its type and a pointer to the next; the loader's one
        // has the content, too.
        unsafe {
            if (*at).kind == kind && (*at).function == function {
                return Some(at.cast_mut());
            }
            at = (*at).next.cast();
        }
    }
    None
}

/// Takes the link of this layer out of an instance's chain, so that the next layer finds its own
/// link.
///
/// # Safety
/// `chain` must be the chain of the loader's call.
pub unsafe fn take_instance_link(chain: *const c_void) -> Option<InstanceLink> {
    // SAFETY: as promised; layers are meant to change these structures of the loader.
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
