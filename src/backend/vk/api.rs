//! The functions of a program's device.

use crate::error::{Error, ErrorKind, Result};
use ash::vk;

/// A device and its functions; cloning copies tables of pointers.
#[derive(Clone)]
pub struct Api {
    /// The device's functions.
    pub(super) device: ash::Device,
    /// What kinds of memory there are.
    pub(super) memory: vk::PhysicalDeviceMemoryProperties,
    /// Its limits.
    pub(super) limits: vk::PhysicalDeviceLimits,
    instance: ash::Instance,
    physical_device: vk::PhysicalDevice,
}

impl Api {
    /// From tables that the caller has loaded; in a layer with the next layer's functions.
    pub fn new(instance: &ash::Instance, physical_device: vk::PhysicalDevice, device: &ash::Device) -> Self {
        // SAFETY: the physical device is one of the instance's.
        let (memory, properties) = unsafe {
            (
                instance.get_physical_device_memory_properties(physical_device),
                instance.get_physical_device_properties(physical_device),
            )
        };
        Self { device: device.clone(), memory, limits: properties.limits, instance: instance.clone(), physical_device }
    }

    /// From handles.
    ///
    /// # Safety
    /// `get_instance_proc_addr` is Vulkan's and finds every function of Vulkan 1.0 for `instance`; the
    /// handles are live and belong together, and stay live as long as what is returned is used.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] where a handle is null.
    pub unsafe fn from_handles(
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
        device: vk::Device,
    ) -> Result<Self> {
        use ash::vk::Handle;
        let handles = [
            ("instance", instance.as_raw()),
            ("physical_device", physical_device.as_raw()),
            ("device", device.as_raw()),
        ];
        if let Some((name, _)) = handles.iter().find(|(_, raw)| *raw == 0) {
            return Err(Error::new(ErrorKind::InvalidArgument, format!("`{name}` is VK_NULL_HANDLE")));
        }
        // SAFETY: as promised above.
        let (instance, device) = unsafe {
            let instance = ash::Instance::load(&ash::StaticFn { get_instance_proc_addr }, instance);
            let device = ash::Device::load(instance.fp_v1_0(), device);
            (instance, device)
        };
        Ok(Self::new(&instance, physical_device, &device))
    }

    /// What images of `format` with optimal tiling can be used for.
    pub(super) fn features(&self, format: vk::Format) -> vk::FormatFeatureFlags {
        // SAFETY: the physical device is one of the instance's.
        unsafe { self.instance.get_physical_device_format_properties(self.physical_device, format) }
            .optimal_tiling_features
    }
}

/// An error that says that Vulkan refused `what`.
pub(super) fn refused(what: &str) -> impl Fn(vk::Result) -> Error + '_ {
    move |result| Error::new(ErrorKind::Graphics, format!("Vulkan refuses {what}: {result:?}."))
}
