//! Counter of primitives that the dividing stage did not divide enough. The statistics use it.

use crate::intercept::vk::state::driver::Driver;
use ash::prelude::VkResult;
use ash::vk;

/// Length of the counter in bytes.
const LENGTH: u64 = size_of::<u32>() as u64;

/// A counter in a buffer of Cupola that shader stages increment.
pub struct Counter {
    buffer: vk::Buffer,
    memory: vk::DeviceMemory,
    address: usize,
}

impl Counter {
    /// Makes a counter at 0.
    ///
    /// # Errors
    /// The driver's.
    pub fn new(driver: &Driver) -> VkResult<Self> {
        let mut counter = Self { buffer: vk::Buffer::null(), memory: vk::DeviceMemory::null(), address: 0 };
        counter.fill(driver).inspect_err(|_| counter.destroy(driver))?;
        Ok(counter)
    }

    fn fill(&mut self, driver: &Driver) -> VkResult<()> {
        let functions = &driver.functions;
        let info = vk::BufferCreateInfo::default().size(LENGTH).usage(vk::BufferUsageFlags::STORAGE_BUFFER);
        let visible = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        // SAFETY: makes objects of Cupola on a live device; they are stored in `self` as soon as
        // they are made. The memory has the length of the counter, and nothing uses it yet.
        unsafe {
            self.buffer = functions.create_buffer(&info, None)?;
            let needs = functions.get_buffer_memory_requirements(self.buffer);
            let near = driver.memory_type(needs.memory_type_bits, visible | vk::MemoryPropertyFlags::DEVICE_LOCAL);
            let kind = near.or_else(|| driver.memory_type(needs.memory_type_bits, visible)).unwrap_or(0);
            let allocation = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
            self.memory = functions.allocate_memory(&allocation, None)?;
            functions.bind_buffer_memory(self.buffer, self.memory, 0)?;
            let flags = vk::MemoryMapFlags::empty();
            let address = functions.map_memory(self.memory, 0, vk::WHOLE_SIZE, flags)?.cast::<u32>();
            address.write_volatile(0);
            self.address = address as usize;
        }
        Ok(())
    }

    /// Returns the counter for a descriptor.
    pub fn descriptor(&self) -> vk::DescriptorBufferInfo {
        vk::DescriptorBufferInfo { buffer: self.buffer, offset: 0, range: LENGTH }
    }

    /// Makes earlier counts visible to the host, once the commands are done.
    ///
    /// # Safety
    /// The command buffer is being recorded, outside of render passes, for queues that draw.
    pub unsafe fn show(driver: &Driver, buffer: vk::CommandBuffer) {
        let seen = vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::SHADER_WRITE)
            .dst_access_mask(vk::AccessFlags::HOST_READ);
        let (from, to) = (vk::PipelineStageFlags::GEOMETRY_SHADER, vk::PipelineStageFlags::HOST);
        // SAFETY: as promised; a device that counts has geometry shaders.
        unsafe {
            let functions = &driver.functions;
            functions.cmd_pipeline_barrier(buffer, from, to, vk::DependencyFlags::empty(), &[seen], &[], &[]);
        }
    }

    /// Returns the count of all commands that are done.
    pub fn read(&self) -> u32 {
        // SAFETY: the memory stays mapped; the device changes the counter atomically.
        unsafe { (self.address as *const u32).read_volatile() }
    }

    /// Destroys the counter.
    pub fn destroy(&self, driver: &Driver) {
        // SAFETY: objects of Cupola or null; the device has finished with them.
        unsafe {
            driver.functions.destroy_buffer(self.buffer, None);
            driver.functions.free_memory(self.memory, None);
        }
    }
}
