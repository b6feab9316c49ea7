//! Buffers and images of Cupola. Each has its own memory allocation: their number is far below the
//! limit of every device.

use super::barrier::COLOR;
use crate::backend::vk::driver::api::{Api, refused};
use crate::error::{Error, ErrorKind, Result};
use ash::vk;

/// A buffer that the processor writes or reads.
#[derive(Debug, Default)]
pub struct Buffer {
    /// Vulkan's handle; null before it is made.
    pub handle: vk::Buffer,
    pub(super) memory: vk::DeviceMemory,
}

/// A 2D image with one level, and a view of all its layers.
#[derive(Debug, Default)]
pub(super) struct Image {
    pub handle: vk::Image,
    pub view: vk::ImageView,
    memory: vk::DeviceMemory,
}

impl Buffer {
    /// Makes a buffer of `size` bytes in memory that the processor can map and that needs no flush.
    pub fn new(api: &Api, size: usize, usage: vk::BufferUsageFlags) -> Result<Self> {
        let mut buffer = Self::default();
        buffer.make(api, size.max(4) as u64, usage).inspect_err(|_| buffer.destroy(api))?;
        Ok(buffer)
    }

    fn make(&mut self, api: &Api, size: u64, usage: vk::BufferUsageFlags) -> Result<()> {
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        // SAFETY: the device is live; the structure is complete; the memory fits the buffer's
        // requirements.
        unsafe {
            self.handle = api.device.create_buffer(&info, None).map_err(refused("a buffer"))?;
            let needs = api.device.get_buffer_memory_requirements(self.handle);
            let visible = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
            self.memory = allocate(api, &needs, visible)?;
            api.device.bind_buffer_memory(self.handle, self.memory, 0).map_err(refused("memory of a buffer"))
        }
    }

    /// Writes `bytes` at `offset`; both lie within the buffer's size.
    pub fn write(&self, api: &Api, offset: usize, bytes: &[u8]) -> Result<()> {
        if bytes.is_empty() {
            return Ok(());
        }
        // SAFETY: the memory is Cupola's, host-visible, not mapped, and as large as the caller
        // promises.
        unsafe {
            let flags = vk::MemoryMapFlags::empty();
            let place = api.device.map_memory(self.memory, offset as u64, bytes.len() as u64, flags);
            let place = place.map_err(refused("to map memory"))?;
            std::ptr::copy_nonoverlapping(bytes.as_ptr(), place.cast(), bytes.len());
            api.device.unmap_memory(self.memory);
        }
        Ok(())
    }

    /// Reads `bytes.len()` bytes from the beginning. The buffer must be at least as long.
    pub fn read(&self, api: &Api, bytes: &mut [u8]) -> Result<()> {
        // SAFETY: as in `write`.
        unsafe {
            let place = api.device.map_memory(self.memory, 0, bytes.len() as u64, vk::MemoryMapFlags::empty());
            let place = place.map_err(refused("to map memory"))?;
            std::ptr::copy_nonoverlapping(place.cast(), bytes.as_mut_ptr(), bytes.len());
            api.device.unmap_memory(self.memory);
        }
        Ok(())
    }

    /// Destroys the buffer. No pending commands may use it.
    pub fn destroy(&mut self, api: &Api) {
        let Self { handle, memory } = std::mem::take(self);
        // SAFETY: both are objects of Cupola or null.
        unsafe {
            api.device.destroy_buffer(handle, None);
            api.device.free_memory(memory, None);
        }
    }
}

impl Image {
    /// Makes an image of `size` (width, height in pixels).
    pub fn new(api: &Api, format: vk::Format, size: (u32, u32), usage: vk::ImageUsageFlags) -> Result<Self> {
        Self::layered(api, format, size, None, usage)
    }

    /// As [`Image::new`], with a number of layers. The view is then that of an array.
    pub fn layered(
        api: &Api,
        format: vk::Format,
        size: (u32, u32),
        layers: Option<u32>,
        usage: vk::ImageUsageFlags,
    ) -> Result<Self> {
        let most = api.limits.max_image_dimension2_d;
        if size.0 == 0 || size.1 == 0 || size.0.max(size.1) > most {
            let message =
                format!("The device cannot make an image of {} × {} pixels; it supports 1 to {most}.", size.0, size.1);
            return Err(Error::new(ErrorKind::Graphics, message));
        }
        let most = api.limits.max_image_array_layers;
        if let Some(layers) = layers.filter(|&layers| layers == 0 || layers > most) {
            let message = format!("The device cannot make an image of {layers} layers; it supports 1 to {most}.");
            return Err(Error::new(ErrorKind::Graphics, message));
        }
        let mut image = Self::default();
        image.make(api, format, size, layers, usage).inspect_err(|_| image.destroy(api))?;
        Ok(image)
    }

    fn make(
        &mut self,
        api: &Api,
        format: vk::Format,
        size: (u32, u32),
        layers: Option<u32>,
        usage: vk::ImageUsageFlags,
    ) -> Result<()> {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(vk::Extent3D { width: size.0, height: size.1, depth: 1 })
            .mip_levels(1)
            .array_layers(layers.unwrap_or(1))
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        // SAFETY: the device is live; the structures are complete; the memory fits the image's
        // requirements.
        unsafe {
            self.handle = api.device.create_image(&info, None).map_err(refused("an image"))?;
            let needs = api.device.get_image_memory_requirements(self.handle);
            self.memory = allocate(api, &needs, vk::MemoryPropertyFlags::empty())?;
            api.device.bind_image_memory(self.handle, self.memory, 0).map_err(refused("memory of an image"))?;
            let info = vk::ImageViewCreateInfo::default()
                .image(self.handle)
                .view_type(layers.map_or(vk::ImageViewType::TYPE_2D, |_| vk::ImageViewType::TYPE_2D_ARRAY))
                .format(format)
                .subresource_range(vk::ImageSubresourceRange { layer_count: layers.unwrap_or(1), ..COLOR });
            self.view = api.device.create_image_view(&info, None).map_err(refused("a view of an image"))?;
        }
        Ok(())
    }

    /// Destroys the image. No pending commands may use it.
    pub fn destroy(&mut self, api: &Api) {
        let Self { handle, view, memory } = std::mem::take(self);
        // SAFETY: all are objects of Cupola or null.
        unsafe {
            api.device.destroy_image_view(view, None);
            api.device.destroy_image(handle, None);
            api.device.free_memory(memory, None);
        }
    }
}

/// Allocates memory for `needs` with all properties of `wanted`. If nothing is wanted, memory of
/// the device itself is preferred.
fn allocate(api: &Api, needs: &vk::MemoryRequirements, wanted: vk::MemoryPropertyFlags) -> Result<vk::DeviceMemory> {
    let find = |flags: vk::MemoryPropertyFlags| {
        let types = api.memory.memory_types.iter().take(api.memory.memory_type_count as usize);
        types.enumerate().position(|(i, t)| needs.memory_type_bits >> i & 1 == 1 && t.property_flags.contains(flags))
    };
    let preferred = if wanted.is_empty() { vk::MemoryPropertyFlags::DEVICE_LOCAL } else { wanted };
    let index = find(preferred).or_else(|| find(wanted)).ok_or_else(|| {
        Error::new(ErrorKind::Graphics, format!("The device has no memory with the needed properties {wanted:?}."))
    })?;
    let info = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(index as u32);
    // SAFETY: the device is live; the index is one of its types.
    unsafe { api.device.allocate_memory(&info, None) }.map_err(refused("memory"))
}
