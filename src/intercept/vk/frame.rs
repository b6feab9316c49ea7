//! Pictures between a device's images and memory that we can read and write.

use super::device::Device;
use ash::{prelude::VkResult, vk};

/// Memory of the host that the device copies from and to.
struct Staging {
    buffer: vk::Buffer,
    memory: vk::DeviceMemory,
    bytes: *mut u8,
    length: usize,
}

// SAFETY: the mapping belongs to the object and may be used by any one thread at a time.
unsafe impl Send for Staging {}

impl Staging {
    /// # Safety
    /// The device must be live.
    unsafe fn new(device: &Device, length: usize) -> VkResult<Self> {
        let functions = &device.functions;
        let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(length as u64).usage(usage);
        // SAFETY: makes objects of ours; what was made before a failure is destroyed.
        unsafe {
            let buffer = functions.create_buffer(&info, None)?;
            let needs = functions.get_buffer_memory_requirements(buffer);
            let visible = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
            let cached = visible | vk::MemoryPropertyFlags::HOST_CACHED;
            let kind = device.memory_type(needs.memory_type_bits, cached);
            let kind = kind.or_else(|| device.memory_type(needs.memory_type_bits, visible)).unwrap_or(0);
            let allocation = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
            let memory =
                functions.allocate_memory(&allocation, None).inspect_err(|_| functions.destroy_buffer(buffer, None))?;
            let mapped = functions
                .bind_buffer_memory(buffer, memory, 0)
                .and_then(|()| functions.map_memory(memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty()));
            match mapped {
                Ok(bytes) => Ok(Self { buffer, memory, bytes: bytes.cast(), length }),
                Err(error) => {
                    functions.destroy_buffer(buffer, None);
                    functions.free_memory(memory, None);
                    Err(error)
                }
            }
        }
    }

    /// # Safety
    /// The device must have finished with it.
    unsafe fn destroy(&self, device: &Device) {
        // SAFETY: as promised.
        unsafe {
            device.functions.destroy_buffer(self.buffer, None);
            device.functions.free_memory(self.memory, None);
        }
    }
}

/// What the frames of a swapchain need; one frame at a time is on its way.
pub struct Frame {
    family: u32,
    extent: vk::Extent2D,
    pool: vk::CommandPool,
    buffer: vk::CommandBuffer,
    fence: vk::Fence,
    /// For each image: signalled when it may be presented.
    ready: Vec<vk::Semaphore>,
    from: Staging,
    to: Staging,
}

impl Frame {
    /// For `images` images of `extent` with four bytes for each pixel, on queues of `family`.
    ///
    /// # Errors
    /// The driver's.
    ///
    /// # Safety
    /// The device must be live.
    pub unsafe fn new(device: &Device, family: u32, extent: vk::Extent2D, images: usize) -> VkResult<Self> {
        let functions = &device.functions;
        let length = extent.width as usize * extent.height as usize * 4;
        let pool = vk::CommandPoolCreateInfo::default()
            .queue_family_index(family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: makes objects of ours; what was made before a failure is destroyed.
        unsafe {
            let from = Staging::new(device, length)?;
            let to = Staging::new(device, length).inspect_err(|_| from.destroy(device))?;
            let mut frame = Self {
                family,
                extent,
                pool: vk::CommandPool::null(),
                buffer: vk::CommandBuffer::null(),
                fence: vk::Fence::null(),
                ready: Vec::new(),
                from,
                to,
            };
            let mut fill = || {
                frame.pool = functions.create_command_pool(&pool, None)?;
                let info = vk::CommandBufferAllocateInfo::default().command_pool(frame.pool).command_buffer_count(1);
                frame.buffer = functions.allocate_command_buffers(&info)?.first().copied().unwrap_or_default();
                device.adopt(frame.buffer).result()?;
                frame.fence = functions.create_fence(&vk::FenceCreateInfo::default(), None)?;
                for _ in 0..images {
                    frame.ready.push(functions.create_semaphore(&vk::SemaphoreCreateInfo::default(), None)?);
                }
                Ok(())
            };
            match fill() {
                Ok(()) => Ok(frame),
                Err(error) => {
                    frame.destroy(device);
                    Err(error)
                }
            }
        }
    }

    /// The queue family that it is for.
    pub fn family(&self) -> u32 {
        self.family
    }

    /// The semaphore that the presentation of an image waits for.
    pub fn ready(&self, image: usize) -> Option<vk::Semaphore> {
        self.ready.get(image).copied()
    }

    /// What [`Frame::read`] read, and what [`Frame::write`] will write; rows from the top.
    pub fn pictures(&mut self) -> (&[u8], &mut [u8]) {
        // SAFETY: both mappings have this length, and the device has finished with them.
        unsafe {
            let from = std::slice::from_raw_parts(self.from.bytes, self.from.length);
            (from, std::slice::from_raw_parts_mut(self.to.bytes, self.to.length))
        }
    }

    /// Copies an image that is ready to be presented, after `waits`; it stays ready. Returns when it is here.
    ///
    /// # Errors
    /// The driver's.
    ///
    /// # Safety
    /// `queue` must be of the family and not in use by another thread; the image, of the extent, can be copied from.
    pub unsafe fn read(
        &mut self,
        device: &Device,
        queue: vk::Queue,
        image: vk::Image,
        waits: &[vk::Semaphore],
        signal: Option<vk::Semaphore>,
    ) -> VkResult<()> {
        let presented = (vk::ImageLayout::PRESENT_SRC_KHR, vk::AccessFlags::MEMORY_WRITE);
        let read = (vk::ImageLayout::TRANSFER_SRC_OPTIMAL, vk::AccessFlags::TRANSFER_READ);
        // SAFETY: as promised; the buffer is as large as the image.
        unsafe {
            self.submit(device, queue, waits, signal, |functions, buffer| {
                barrier(functions, buffer, image, presented, read);
                functions.cmd_copy_image_to_buffer(buffer, image, read.0, self.from.buffer, &[self.whole()]);
                barrier(functions, buffer, image, read, (presented.0, vk::AccessFlags::empty()));
                let seen = vk::MemoryBarrier::default()
                    .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
                    .dst_access_mask(vk::AccessFlags::HOST_READ);
                let (transfer, host) = (vk::PipelineStageFlags::TRANSFER, vk::PipelineStageFlags::HOST);
                functions.cmd_pipeline_barrier(buffer, transfer, host, vk::DependencyFlags::empty(), &[seen], &[], &[]);
            })
        }
    }

    /// Copies the picture to an image and makes it ready to be presented.
    ///
    /// # Errors
    /// The driver's.
    ///
    /// # Safety
    /// As for [`Frame::read`]; the image can be copied to.
    pub unsafe fn write(
        &mut self,
        device: &Device,
        queue: vk::Queue,
        image: vk::Image,
        waits: &[vk::Semaphore],
        signal: vk::Semaphore,
    ) -> VkResult<()> {
        let before = (vk::ImageLayout::UNDEFINED, vk::AccessFlags::empty());
        let written = (vk::ImageLayout::TRANSFER_DST_OPTIMAL, vk::AccessFlags::TRANSFER_WRITE);
        // SAFETY: as promised; the buffer is as large as the image.
        unsafe {
            self.submit(device, queue, waits, Some(signal), |functions, buffer| {
                barrier(functions, buffer, image, before, written);
                functions.cmd_copy_buffer_to_image(buffer, self.to.buffer, image, written.0, &[self.whole()]);
                barrier(
                    functions,
                    buffer,
                    image,
                    written,
                    (vk::ImageLayout::PRESENT_SRC_KHR, vk::AccessFlags::empty()),
                );
            })
        }
    }

    /// Records and submits, and waits for it.
    ///
    /// # Safety
    /// As for [`Frame::read`].
    unsafe fn submit(
        &self,
        device: &Device,
        queue: vk::Queue,
        waits: &[vk::Semaphore],
        signal: Option<vk::Semaphore>,
        record: impl FnOnce(&ash::Device, vk::CommandBuffer),
    ) -> VkResult<()> {
        let functions = &device.functions;
        let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let stages = vec![vk::PipelineStageFlags::TRANSFER; waits.len()];
        let (buffers, signals) = ([self.buffer], signal.as_slice());
        let work = vk::SubmitInfo::default()
            .wait_semaphores(waits)
            .wait_dst_stage_mask(&stages)
            .command_buffers(&buffers)
            .signal_semaphores(signals);
        // SAFETY: the command buffer is not pending, since each submission is waited for.
        unsafe {
            functions.begin_command_buffer(self.buffer, &once)?;
            record(functions, self.buffer);
            functions.end_command_buffer(self.buffer)?;
            functions.queue_submit(queue, &[work], self.fence)?;
            functions.wait_for_fences(&[self.fence], true, u64::MAX)?;
            functions.reset_fences(&[self.fence])
        }
    }

    fn whole(&self) -> vk::BufferImageCopy {
        vk::BufferImageCopy::default()
            .image_subresource(
                vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1),
            )
            .image_extent(vk::Extent3D { width: self.extent.width, height: self.extent.height, depth: 1 })
    }

    /// # Safety
    /// The device must be live; presentations that wait for its semaphores must be over.
    pub unsafe fn destroy(&self, device: &Device) {
        let functions = &device.functions;
        // SAFETY: as promised; each submission was waited for, and destroying null objects does nothing.
        unsafe {
            for semaphore in &self.ready {
                functions.destroy_semaphore(*semaphore, None);
            }
            functions.destroy_fence(self.fence, None);
            functions.destroy_command_pool(self.pool, None);
            self.from.destroy(device);
            self.to.destroy(device);
        }
    }
}

/// Takes an image from a layout and access to another, for a copy.
///
/// # Safety
/// The image must be in that layout, the command buffer being recorded.
unsafe fn barrier(
    functions: &ash::Device,
    buffer: vk::CommandBuffer,
    image: vk::Image,
    from: (vk::ImageLayout, vk::AccessFlags),
    to: (vk::ImageLayout, vk::AccessFlags),
) {
    let range =
        vk::ImageSubresourceRange::default().aspect_mask(vk::ImageAspectFlags::COLOR).level_count(1).layer_count(1);
    let change = vk::ImageMemoryBarrier::default()
        .image(image)
        .old_layout(from.0)
        .new_layout(to.0)
        .src_access_mask(from.1)
        .dst_access_mask(to.1)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .subresource_range(range);
    let stages = vk::PipelineStageFlags::ALL_COMMANDS;
    // SAFETY: as promised.
    unsafe {
        functions.cmd_pipeline_barrier(buffer, stages, stages, vk::DependencyFlags::empty(), &[], &[], &[change])
    };
}
