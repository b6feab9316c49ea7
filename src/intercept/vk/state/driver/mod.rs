//! The driver's side of a device: its functions, limits, memory and queues.
//!
//! [`instance`] holds the next layer's functions for an instance. [`entry_points`] holds the
//! functions of a device that hooks call. [`structures`] reads the structures that the program
//! passes to Vulkan. [`own_image`] makes images of Cupola. [`xcb`] asks for sizes of X11 windows.
//! Nothing here depends on views.

pub mod entry_points;
pub mod instance;
pub mod own_image;
pub mod structures;
pub mod xcb;

use crate::backend::vk::Api;
use crate::intercept::vk::state::driver::instance::Instance;
use ash::prelude::VkResult;
use ash::{khr, vk};
use std::ffi::c_void;
use std::sync::Arc;

/// `PFN_vkSetDeviceLoaderData`: prepares an object that a layer made for the loader's dispatch.
pub type SetDeviceLoaderData = unsafe extern "system" fn(vk::Device, *mut c_void) -> vk::Result;

/// A queue and its family.
#[derive(Clone, Copy, Debug)]
pub struct Queue {
    pub(in crate::intercept::vk) handle: vk::Queue,
    pub(in crate::intercept::vk) family: u32,
}

/// The driver's side of a device.
pub struct Driver {
    /// The next layer's `vkGetDeviceProcAddr`.
    pub(in crate::intercept::vk) get_device_proc_addr: vk::PFN_vkGetDeviceProcAddr,
    /// The next layer's functions.
    pub(in crate::intercept::vk) functions: ash::Device,
    /// The functions of `VK_KHR_swapchain`. They may be called only if the program enabled it.
    pub(in crate::intercept::vk) swapchain: khr::swapchain::DeviceFn,
    /// The same device for the correction.
    pub(in crate::intercept::vk) api: Api,
    /// The instance, for queries about surfaces.
    pub(in crate::intercept::vk) instance: Arc<Instance>,
    /// The device that it was made from.
    pub(in crate::intercept::vk) physical: vk::PhysicalDevice,
    pub(in crate::intercept::vk) limits: vk::PhysicalDeviceLimits,
    pub(in crate::intercept::vk) memory: vk::PhysicalDeviceMemoryProperties,
    /// Name of the driver's device and its version, for the statistics.
    pub(in crate::intercept::vk) name: String,
    /// Capabilities of each queue family.
    pub(in crate::intercept::vk) families: Vec<vk::QueueFlags>,
    /// The loader's function for objects that a layer makes.
    pub(in crate::intercept::vk) set_loader_data: Option<SetDeviceLoaderData>,
}

impl Driver {
    /// Makes a primary command buffer of Cupola that the layers below can dispatch.
    ///
    /// # Errors
    /// The driver's.
    ///
    /// # Safety
    /// The pool must be one of Cupola's, in use by no other thread.
    pub unsafe fn command_buffer(&self, pool: vk::CommandPool) -> VkResult<vk::CommandBuffer> {
        // SAFETY: as promised.
        unsafe { self.allocate(pool, vk::CommandBufferLevel::PRIMARY) }
    }

    /// Makes a secondary command buffer.
    ///
    /// # Errors
    /// The driver's.
    ///
    /// # Safety
    /// The pool must be in use by no other thread.
    pub unsafe fn secondary_command_buffer(&self, pool: vk::CommandPool) -> VkResult<vk::CommandBuffer> {
        // SAFETY: as promised.
        unsafe { self.allocate(pool, vk::CommandBufferLevel::SECONDARY) }
    }

    /// # Safety
    /// The pool must be in use by no other thread.
    unsafe fn allocate(&self, pool: vk::CommandPool, level: vk::CommandBufferLevel) -> VkResult<vk::CommandBuffer> {
        let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).level(level).command_buffer_count(1);
        // SAFETY: as promised; the loader's own function, for an object of its device.
        unsafe {
            let buffer = self.functions.allocate_command_buffers(&info)?.first().copied().unwrap_or_default();
            let set = self.set_loader_data.ok_or(vk::Result::ERROR_INITIALIZATION_FAILED)?;
            set(self.functions.handle(), vk::Handle::as_raw(buffer) as *mut _).result()?;
            Ok(buffer)
        }
    }

    /// Greatest width and height of an image that can be drawn to.
    pub fn greatest_image(&self) -> u32 {
        let limits = &self.limits;
        limits.max_image_dimension2_d.min(limits.max_framebuffer_width).min(limits.max_framebuffer_height)
    }

    /// Returns the memory type among `allowed` with all properties of `wanted`.
    pub fn memory_type(&self, allowed: u32, wanted: vk::MemoryPropertyFlags) -> Option<u32> {
        let kinds = self.memory.memory_types_as_slice().iter().enumerate();
        let mut fitting =
            kinds.filter(|(index, kind)| allowed & (1 << index) != 0 && kind.property_flags.contains(wanted));
        fitting.next().map(|(index, _)| index as u32)
    }
}
