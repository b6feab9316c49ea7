//! The functions of a program's device.

use crate::cache::Cache;
use crate::error::{Error, ErrorKind, Result};
use ash::vk;
use std::ffi::{CStr, c_void};

/// A device and its functions; cloning copies tables of pointers.
#[derive(Clone)]
pub struct Api {
    /// The device's functions.
    pub(in crate::backend::vk) device: ash::Device,
    /// Kinds of memory that the device has.
    pub(in crate::backend::vk) memory: vk::PhysicalDeviceMemoryProperties,
    /// Its limits.
    pub(in crate::backend::vk) limits: vk::PhysicalDeviceLimits,
    instance: ash::Instance,
    physical_device: vk::PhysicalDevice,
    /// Cache of compiled pipelines.
    pub(in crate::backend::vk) cache: Cache,
    /// Part of the cache's keys: identity of the driver and of the device.
    pub(in crate::backend::vk) driver: Vec<u8>,
}

impl Api {
    /// Makes it from function tables that the caller has loaded. In a layer these contain the next
    /// layer's functions.
    pub fn new(instance: &ash::Instance, physical_device: vk::PhysicalDevice, device: &ash::Device) -> Self {
        // SAFETY: the physical device is one of the instance's.
        let (memory, properties) = unsafe {
            (
                instance.get_physical_device_memory_properties(physical_device),
                instance.get_physical_device_properties(physical_device),
            )
        };
        let numbers = [properties.vendor_id, properties.device_id, properties.driver_version];
        let mut driver: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        driver.extend_from_slice(&properties.pipeline_cache_uuid);
        Self {
            device: device.clone(),
            memory,
            limits: properties.limits,
            instance: instance.clone(),
            physical_device,
            cache: Cache::none(),
            driver,
        }
    }

    /// True if the device has an extension.
    pub fn has_extension(&self, name: &CStr) -> bool {
        // SAFETY: the physical device is one of the instance's, and both are live.
        let extensions = unsafe { self.instance.enumerate_device_extension_properties(self.physical_device) };
        extensions.is_ok_and(|all| all.iter().any(|one| one.extension_name_as_c_str().is_ok_and(|known| known == name)))
    }

    /// Returns the device with `cache` for compiled pipelines.
    pub fn with_cache(mut self, cache: &Cache) -> Self {
        self.cache = cache.clone();
        self
    }

    /// Makes it from handles.
    ///
    /// # Safety
    /// `get_instance_proc_addr` is Vulkan's and finds every function of Vulkan 1.0 for `instance`.
    /// The handles are live, belong together, and stay live as long as the result is used.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] where a handle is null; [`ErrorKind::Graphics`] where a
    /// function of Vulkan 1.0 is not found, for example if the handles belong to different
    /// instances.
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
        let found = |name: &CStr| unsafe { get_instance_proc_addr(instance, name.as_ptr()) };
        // ash ends the process if a function is called that was not found.
        require(|find| _ = ash::InstanceFnV1_0::load(find), |name| address(found(name)))?;
        // SAFETY: as promised above.
        let instance = unsafe { ash::Instance::load(&ash::StaticFn { get_instance_proc_addr }, instance) };
        // SAFETY: as promised above.
        let found = |name: &CStr| unsafe { instance.get_device_proc_addr(device, name.as_ptr()) };
        require(|find| _ = ash::DeviceFnV1_0::load(find), |name| address(found(name)))?;
        // SAFETY: as promised above.
        let device = unsafe { ash::Device::load(instance.fp_v1_0(), device) };
        Ok(Self::new(&instance, physical_device, &device))
    }

    /// The instance, with its functions.
    pub fn instance(&self) -> &ash::Instance {
        &self.instance
    }

    /// The physical device.
    pub fn physical_device(&self) -> vk::PhysicalDevice {
        self.physical_device
    }

    /// The device, with its functions.
    pub fn device(&self) -> &ash::Device {
        &self.device
    }

    /// Greatest width and height of an image.
    pub fn largest_image(&self) -> u32 {
        self.limits.max_image_dimension2_d
    }

    /// Greatest number of descriptor sets of a pipeline.
    pub fn descriptor_sets(&self) -> u32 {
        self.limits.max_bound_descriptor_sets
    }

    /// Checks that queues of `family` can draw.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] where there is no such family, or it cannot draw.
    pub fn check_queue_family(&self, family: u32) -> Result<()> {
        // SAFETY: the physical device is one of the instance's.
        let families = unsafe { self.instance.get_physical_device_queue_family_properties(self.physical_device) };
        let drawing: Vec<usize> = (0..families.len())
            .filter(|&index| families[index].queue_flags.contains(vk::QueueFlags::GRAPHICS))
            .collect();
        if drawing.contains(&(family as usize)) {
            return Ok(());
        }
        let message = format!(
            "queue family {family} cannot draw; of the {} families of the device, {drawing:?} can",
            families.len()
        );
        Err(Error::new(ErrorKind::InvalidArgument, message))
    }

    /// True if corrections in queues of `family` can be timed.
    pub fn has_timestamps(&self, family: u32) -> bool {
        self.timestamp_bits(family) > 0
    }

    /// Returns the number of bits of the timestamps of queues of `family`; 0 if there are none.
    pub(in crate::backend::vk) fn timestamp_bits(&self, family: u32) -> u32 {
        // SAFETY: the physical device is one of the instance's.
        let families = unsafe { self.instance.get_physical_device_queue_family_properties(self.physical_device) };
        families.get(family as usize).map_or(0, |family| family.timestamp_valid_bits)
    }

    /// Returns the possible uses of images of `format` with optimal tiling.
    pub fn features(&self, format: vk::Format) -> vk::FormatFeatureFlags {
        // SAFETY: the physical device is one of the instance's.
        unsafe { self.instance.get_physical_device_format_properties(self.physical_device, format) }
            .optimal_tiling_features
    }
}

fn address(function: vk::PFN_vkVoidFunction) -> *const c_void {
    function.map_or(std::ptr::null(), |function| function as *const c_void)
}

/// Returns the first device function of Vulkan 1.0 that `find` does not find. ash ends the process
/// if such a function is called.
pub fn missing_of_device(find: impl Fn(&CStr) -> *const c_void) -> Option<String> {
    first_missing(|find| _ = ash::DeviceFnV1_0::load(find), find)
}

/// Returns the first function of a table that `find` does not find.
fn first_missing(
    load: impl FnOnce(&mut dyn FnMut(&CStr) -> *const c_void),
    find: impl Fn(&CStr) -> *const c_void,
) -> Option<String> {
    let mut missing = None;
    load(&mut |name: &CStr| {
        let function = find(name);
        if function.is_null() {
            missing.get_or_insert_with(|| name.to_string_lossy().into_owned());
        }
        function
    });
    missing
}

/// Checks that `find` finds every function of a table.
fn require(
    load: impl FnOnce(&mut dyn FnMut(&CStr) -> *const c_void),
    find: impl Fn(&CStr) -> *const c_void,
) -> Result<()> {
    first_missing(load, find).map_or(Ok(()), |name| {
        let message = format!("vkGetInstanceProcAddr does not find {name}; check that it belongs to this instance");
        Err(Error::new(ErrorKind::Graphics, message))
    })
}

/// Returns a function that makes the error that Vulkan refused `what`.
pub fn refused(what: &str) -> impl Fn(vk::Result) -> Error + '_ {
    move |result| Error::new(ErrorKind::Graphics, format!("Vulkan refuses {what}: {result:?}."))
}
