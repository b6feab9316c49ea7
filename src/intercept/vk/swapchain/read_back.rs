//! Read-back of images, for captures. It waits for the device, since captures are not part of a
//! frame.

use crate::correct::PixelRect;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::Queue;
use crate::intercept::vk::state::driver::own_image::{COLOR_LAYER, COPIED_FROM, PRESENTED, barrier};
use crate::intercept::vk::state::swapchains::formats::TexelFormat;
use crate::runtime::run_results::Picture;
use ash::prelude::VkResult;
use ash::vk;

/// Reads an image with texels of `size` bytes, after `waits`. The image has the layout for
/// presentation before and after. The rows start at the top.
///
/// # Errors
/// The driver's.
///
/// # Safety
/// `queue` must not be in use by another thread; the image can be copied from, has the size
/// `extent`, and earlier submissions to the queue leave it ready to be presented.
pub unsafe fn read(
    device: &Device,
    queue: Queue,
    image: vk::Image,
    size: usize,
    extent: vk::Extent2D,
    waits: &[vk::Semaphore],
) -> VkResult<Vec<u8>> {
    let mut reading = Reading::default();
    // SAFETY: as promised; `finish` destroys what was made, after the device has finished with it.
    unsafe {
        let result = reading.run(device, queue, image, size, extent, waits);
        reading.finish(device);
        result
    }
}

/// Objects of one read-back; null until they are made.
#[derive(Default)]
struct Reading {
    buffer: vk::Buffer,
    memory: vk::DeviceMemory,
    pool: vk::CommandPool,
    fence: vk::Fence,
}

impl Reading {
    /// # Safety
    /// As for [`read`].
    unsafe fn run(
        &mut self,
        device: &Device,
        queue: Queue,
        image: vk::Image,
        size: usize,
        extent: vk::Extent2D,
        waits: &[vk::Semaphore],
    ) -> VkResult<Vec<u8>> {
        let functions = &device.driver.functions;
        let length = extent.width as usize * extent.height as usize * size;
        let visible = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let cached = visible | vk::MemoryPropertyFlags::HOST_CACHED;
        let info = vk::BufferCreateInfo::default().size(length as u64).usage(vk::BufferUsageFlags::TRANSFER_DST);
        // SAFETY: as promised; the buffer is as large as the image, and is read after the fence.
        unsafe {
            self.buffer = functions.create_buffer(&info, None)?;
            let needs = functions.get_buffer_memory_requirements(self.buffer);
            let kind = device.driver.memory_type(needs.memory_type_bits, cached);
            let kind = kind.or_else(|| device.driver.memory_type(needs.memory_type_bits, visible)).unwrap_or(0);
            let allocation = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
            self.memory = functions.allocate_memory(&allocation, None)?;
            functions.bind_buffer_memory(self.buffer, self.memory, 0)?;
            let pool = vk::CommandPoolCreateInfo::default().queue_family_index(queue.family);
            self.pool = functions.create_command_pool(&pool, None)?;
            self.fence = functions.create_fence(&vk::FenceCreateInfo::default(), None)?;
            let commands = device.driver.command_buffer(self.pool)?;
            let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            functions.begin_command_buffer(commands, &once)?;
            barrier(&device.driver, commands, image, PRESENTED, COPIED_FROM);
            let region = vk::BufferImageCopy::default().image_subresource(COLOR_LAYER).image_extent(vk::Extent3D {
                width: extent.width,
                height: extent.height,
                depth: 1,
            });
            functions.cmd_copy_image_to_buffer(commands, image, COPIED_FROM.layout, self.buffer, &[region]);
            barrier(&device.driver, commands, image, COPIED_FROM, PRESENTED);
            functions.end_command_buffer(commands)?;
            let (buffers, stages) = ([commands], vec![vk::PipelineStageFlags::ALL_COMMANDS; waits.len()]);
            let work =
                vk::SubmitInfo::default().wait_semaphores(waits).wait_dst_stage_mask(&stages).command_buffers(&buffers);
            functions.queue_submit(queue.handle, &[work], self.fence)?;
            functions.wait_for_fences(&[self.fence], true, u64::MAX)?;
            let bytes = functions.map_memory(self.memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty())?;
            Ok(std::slice::from_raw_parts(bytes.cast::<u8>(), length).to_vec())
        }
    }

    /// # Safety
    /// The device must have finished with it, or have been lost.
    unsafe fn finish(&self, device: &Device) {
        let functions = &device.driver.functions;
        // SAFETY: as promised; destroying null objects does nothing.
        unsafe {
            functions.destroy_fence(self.fence, None);
            functions.destroy_command_pool(self.pool, None);
            functions.destroy_buffer(self.buffer, None);
            functions.free_memory(self.memory, None);
        }
    }
}

/// Copies a rectangle from a picture with rows of `stride` pixels from the top.
pub fn cut(
    bytes: &[u8],
    stride: u32,
    texel_format: TexelFormat,
    name: &str,
    PixelRect { x, y, width, height }: PixelRect,
) -> Picture {
    let mut rgba = Vec::with_capacity(width as usize * height as usize * 4);
    for row in (y..y + height).rev() {
        let start = (row as usize * stride as usize + x as usize) * texel_format.size();
        for texel in bytes[start..start + width as usize * texel_format.size()].chunks_exact(texel_format.size()) {
            let [red, green, blue] = texel_format.color(texel);
            rgba.extend([red, green, blue, 255]);
        }
    }
    Picture { name: name.to_owned(), width, height, rgba }
}

#[cfg(test)]
mod tests {
    use super::{TexelFormat, cut};
    use crate::correct::PixelRect;

    #[test]
    fn a_rectangle_is_cut_and_turned() {
        // 2 × 3 pixels, numbered; each number is in every channel, with a different offset.
        let bytes: Vec<u8> = (0..6).flat_map(|n| [n, 10 + n, 20 + n, 99]).collect();
        let picture = cut(&bytes, 2, TexelFormat::Bgra8, "a", PixelRect::new(1, 1, 1, 2));
        assert_eq!(picture.rgba, [25, 15, 5, 255, 23, 13, 3, 255], "rows from the bottom, red first");
        assert_eq!(cut(&bytes, 2, TexelFormat::Rgba8, "a", PixelRect::new(0, 0, 1, 1)).rgba, [0, 10, 20, 255]);
    }
}
