//! A device without a program and without a window: for tests, measurements and `cupola doctor`.

use crate::backend::vk::barrier::{COLOR, Use, barrier};
use crate::backend::vk::driver::api::{Api, refused};
use crate::backend::vk::images::SourceImage;
use crate::correct::ImageSize;
use crate::error::{Error, ErrorKind, Result};
use ash::vk;
use libloading::Library;
use std::ffi::CStr;

/// A device with one queue and one command buffer, until it is dropped.
pub struct Headless {
    /// The device's functions.
    pub api: Api,
    /// Name that the driver reports.
    pub driver: String,
    queue: vk::Queue,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    family: u32,
    get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
    instance: ash::Instance,
    // Keeps the functions above valid. This is the last field, since fields are dropped in order.
    _library: Library,
}

impl Headless {
    /// Opens the first device that can draw. `layers`: layers to enable.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where there is no Vulkan, no device, or not these layers; the
    /// message says which.
    pub fn new(layers: &[&CStr]) -> Result<Self> {
        // SAFETY: the loader's initialisers are those that every Vulkan program runs.
        let library = unsafe { Library::new("libvulkan.so.1") }
            .map_err(|error| graphics(format!("Vulkan is missing: libvulkan.so.1 cannot be loaded ({error}).")))?;
        // SAFETY: the name's type is that of the Vulkan specification; the library stays loaded.
        let (get_instance_proc_addr, entry) = unsafe {
            let get_instance_proc_addr = *library
                .get(b"vkGetInstanceProcAddr\0")
                .map_err(|error| graphics(format!("libvulkan.so.1 is incomplete: {error}.")))?;
            (get_instance_proc_addr, ash::Entry::from_static_fn(ash::StaticFn { get_instance_proc_addr }))
        };
        let names: Vec<_> = layers.iter().map(|name| name.as_ptr()).collect();
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_0);
        let info = vk::InstanceCreateInfo::default().application_info(&application).enabled_layer_names(&names);
        // SAFETY: the structures are complete and live during the call.
        let instance = unsafe { entry.create_instance(&info, None) }.map_err(refused("an instance"))?;
        match Self::open(&instance) {
            Ok((api, driver, family, queue, pool, commands)) => Ok(Self {
                api,
                driver,
                queue,
                pool,
                commands,
                family,
                get_instance_proc_addr,
                instance,
                _library: library,
            }),
            Err(error) => {
                // SAFETY: an instance of Cupola, without children.
                unsafe { instance.destroy_instance(None) };
                Err(error)
            }
        }
    }

    fn open(instance: &ash::Instance) -> Result<(Api, String, u32, vk::Queue, vk::CommandPool, vk::CommandBuffer)> {
        // SAFETY: the instance is live.
        let devices = unsafe { instance.enumerate_physical_devices() }.map_err(refused("to list devices"))?;
        let drawing = |device: &vk::PhysicalDevice| {
            // SAFETY: the device is one of the instance's.
            let families = unsafe { instance.get_physical_device_queue_family_properties(*device) };
            families.iter().position(|family| family.queue_flags.contains(vk::QueueFlags::GRAPHICS))
        };
        let (physical, family) = devices
            .iter()
            .find_map(|device| Some((*device, drawing(device)? as u32)))
            .ok_or_else(|| graphics("Vulkan lists no device that can draw: no driver is installed.".into()))?;
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
        // SAFETY: the structures are complete; the names are those of the specification.
        unsafe {
            let properties = instance.get_physical_device_properties(physical);
            let version = properties.api_version;
            let (major, minor) = (vk::api_version_major(version), vk::api_version_minor(version));
            let name = properties.device_name_as_c_str().unwrap_or_default().to_string_lossy().into_owned();
            let device = instance.create_device(physical, &info, None).map_err(refused("a device"))?;
            let queue = device.get_device_queue(family, 0);
            let commands = Self::commands(&device, family).inspect_err(|_| device.destroy_device(None))?;
            let api = Api::new(instance, physical, &device);
            Ok((api, format!("{name}, Vulkan {major}.{minor}"), family, queue, commands.0, commands.1))
        }
    }

    fn commands(device: &ash::Device, family: u32) -> Result<(vk::CommandPool, vk::CommandBuffer)> {
        let flags = vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER;
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(family).flags(flags);
        // SAFETY: the device is live.
        let pool = unsafe { device.create_command_pool(&info, None) }.map_err(refused("a command pool"))?;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
        // SAFETY: as above.
        match unsafe { device.allocate_command_buffers(&info) } {
            Ok(buffers) => Ok((pool, buffers[0])),
            Err(result) => {
                // SAFETY: a pool of Cupola.
                unsafe { device.destroy_command_pool(pool, None) };
                Err(refused("a command buffer")(result))
            }
        }
    }

    /// Returns the family of the queue.
    pub fn queue_family(&self) -> u32 {
        self.family
    }

    /// Returns the function that finds the functions of the instance.
    pub fn get_instance_proc_addr(&self) -> vk::PFN_vkGetInstanceProcAddr {
        self.get_instance_proc_addr
    }

    /// Fills images with a colour. `sizes`: size and number of layers of each image.
    ///
    /// # Errors
    /// Those of the device.
    pub fn fill(&self, images: &[SourceImage], sizes: &[ImageSize], color: [f32; 4]) -> Result<()> {
        let (device, color) = (&self.api.device, vk::ClearColorValue { float32: color });
        self.run(|commands| {
            for (source, size) in images.iter().zip(sizes) {
                let (before, image) = (Use::nothing(vk::ImageLayout::UNDEFINED), (source.image, size.layers));
                let range = vk::ImageSubresourceRange { layer_count: size.layers, ..COLOR };
                let after = Use { layout: source.layout, stages: source.stages, access: source.access };
                // SAFETY: the command buffer is being recorded, and the image is live.
                unsafe {
                    barrier(device, commands, image, before, Use::COPIED_TO);
                    device.cmd_clear_color_image(commands, source.image, Use::COPIED_TO.layout, &color, &[range]);
                    barrier(device, commands, image, Use::COPIED_TO, after);
                }
            }
            Ok(())
        })
    }

    /// Records commands, submits them, and waits until they are done.
    ///
    /// # Errors
    /// Those of `record` and of the device.
    pub fn run(&self, record: impl FnOnce(vk::CommandBuffer) -> Result<()>) -> Result<()> {
        let device = &self.api.device;
        let once = vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT;
        let buffers = [self.commands];
        let submits = [vk::SubmitInfo::default().command_buffers(&buffers)];
        // SAFETY: the command buffer is Cupola's and not pending, since each run waits for its end.
        unsafe {
            device
                .begin_command_buffer(self.commands, &vk::CommandBufferBeginInfo::default().flags(once))
                .map_err(refused("to record"))?;
            let recorded = record(self.commands);
            device.end_command_buffer(self.commands).map_err(refused("to end recording"))?;
            recorded?;
            device.queue_submit(self.queue, &submits, vk::Fence::null()).map_err(refused("to submit"))?;
            device.queue_wait_idle(self.queue).map_err(refused("to wait"))
        }
    }
}

impl Drop for Headless {
    fn drop(&mut self) {
        // SAFETY: all are objects of Cupola; nothing is pending.
        unsafe {
            self.api.device.destroy_command_pool(self.pool, None);
            self.api.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }
}

fn graphics(message: String) -> Error {
    Error::new(ErrorKind::Graphics, message)
}
