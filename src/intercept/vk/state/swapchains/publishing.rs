//! Read-back of the published pictures of a window.

use crate::intercept::process::publishing;
use crate::intercept::vk::state::driver::Driver;
use crate::intercept::vk::state::driver::Queue;
use crate::intercept::vk::state::driver::own_image::{COLOR_LAYER, COPIED_FROM, PRESENTED, barrier};
use crate::intercept::vk::state::swapchains::formats::TexelFormat;
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::ring::{Format, Pictures, Shape, Stamp};
use ash::prelude::VkResult;
use ash::vk;
use std::sync::Arc;

/// Greatest number of frames that are read back at the same time. Further frames are left out.
const FRAMES: usize = 3;

/// Longest time of the device for a frame that the program waits for, in nanoseconds.
const LONGEST_WAIT: u64 = 60_000_000_000;

/// Alignment of the pictures in the buffer, which is enough for copies on any device.
const ALIGNMENT: usize = 64;

/// A published picture: its source, and its region in the buffer.
#[derive(Clone, Copy)]
struct Region {
    /// Index of the image outside of the window; `None`: the window.
    beside: Option<usize>,
    copy: vk::BufferImageCopy,
}

/// A frame that is read back. Objects are null until they are made.
#[derive(Default)]
struct Transfer {
    buffer: vk::Buffer,
    memory: vk::DeviceMemory,
    /// Address of its bytes.
    bytes: usize,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    done: vk::Fence,
    stamp: Stamp,
}

/// Source of the pictures of a window.
pub(in crate::intercept::vk) struct Publishing {
    /// The plan that it belongs to; `None` if the window is not corrected.
    pub(in crate::intercept::vk) layout: Option<Arc<AtlasLayout>>,
    /// The family of the queue that presents.
    pub(in crate::intercept::vk) family: u32,
    format: TexelFormat,
    shapes: Vec<Shape>,
    /// Format of the published pixels.
    published: Format,
    regions: Vec<Region>,
    bytes: usize,
    transfers: [Transfer; FRAMES],
    next: usize,
    oldest: usize,
    /// Semaphores that are signalled when an image of the swapchain has been copied, one for each.
    copied: Vec<vk::Semaphore>,
    /// Row of a picture with the other order of colours.
    row: Vec<u8>,
}

impl Publishing {
    /// Makes the read-back for a window with `images` images. `pictures`: name, index of an image
    /// outside of the window, rectangle.
    ///
    /// # Errors
    /// The driver's.
    ///
    /// # Safety
    /// The device must be live.
    pub(in crate::intercept::vk) unsafe fn new(
        driver: &Driver,
        (layout, family, format): (Option<Arc<AtlasLayout>>, u32, TexelFormat),
        images: usize,
        pictures: impl Iterator<Item = (String, Option<usize>, vk::Rect2D)>,
    ) -> VkResult<Self> {
        let published = if publishing::is_deep() { Format::Rgba16 } else { Format::Rgba8 };
        let (mut shapes, mut regions, mut bytes) = (Vec::new(), Vec::new(), 0_usize);
        for (name, beside, vk::Rect2D { offset, extent: vk::Extent2D { width, height } }) in pictures {
            if width == 0 || height == 0 {
                continue;
            }
            let copy = vk::BufferImageCopy::default()
                .buffer_offset(bytes as u64)
                .image_subresource(COLOR_LAYER)
                .image_offset(vk::Offset3D { x: offset.x, y: offset.y, z: 0 })
                .image_extent(vk::Extent3D { width, height, depth: 1 });
            bytes += (width as usize * height as usize * format.size()).next_multiple_of(ALIGNMENT);
            shapes.push(Shape { name, size: (width, height), format: published });
            regions.push(Region { beside, copy });
        }
        let widest = shapes.iter().map(|shape| shape.size.0 as usize * published.pixel_bytes()).max().unwrap_or(0);
        let mut new = Self {
            layout,
            family,
            format,
            shapes,
            published,
            regions,
            bytes,
            transfers: Default::default(),
            next: 0,
            oldest: 0,
            copied: Vec::new(),
            row: Vec::with_capacity(widest),
        };
        // SAFETY: as promised; after a failure, the objects made so far are destroyed.
        unsafe { new.make(driver, images).inspect_err(|_| new.destroy(driver))? };
        Ok(new)
    }

    /// # Safety
    /// As for [`Publishing::new`].
    unsafe fn make(&mut self, driver: &Driver, images: usize) -> VkResult<()> {
        let functions = &driver.functions;
        let visible = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        let info =
            vk::BufferCreateInfo::default().size(self.bytes.max(1) as u64).usage(vk::BufferUsageFlags::TRANSFER_DST);
        let pool = vk::CommandPoolCreateInfo::default()
            .queue_family_index(self.family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: as promised; the buffer stays mapped until its memory is freed.
        unsafe {
            for _ in 0..images {
                self.copied.push(functions.create_semaphore(&vk::SemaphoreCreateInfo::default(), None)?);
            }
            for transfer in &mut self.transfers {
                transfer.buffer = functions.create_buffer(&info, None)?;
                let needs = functions.get_buffer_memory_requirements(transfer.buffer);
                let kind = |wanted| driver.memory_type(needs.memory_type_bits, wanted);
                let kind = kind(visible | vk::MemoryPropertyFlags::HOST_CACHED).or_else(|| kind(visible)).unwrap_or(0);
                let allocation = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
                transfer.memory = functions.allocate_memory(&allocation, None)?;
                functions.bind_buffer_memory(transfer.buffer, transfer.memory, 0)?;
                let bytes = functions.map_memory(transfer.memory, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty())?;
                transfer.bytes = bytes.expose_provenance();
                transfer.pool = functions.create_command_pool(&pool, None)?;
                transfer.commands = driver.command_buffer(transfer.pool)?;
                transfer.done = functions.create_fence(&vk::FenceCreateInfo::default(), None)?;
            }
        }
        Ok(())
    }

    /// Copies the pictures of a frame after `waits`, from image `index` of the swapchain and from
    /// the images `beside` the window. They are published when the device has finished. Returns the
    /// semaphore that the presentation has to wait for; `None` if the device has not finished the
    /// earlier frames.
    ///
    /// # Errors
    /// The driver's errors; nothing was submitted then.
    ///
    /// # Safety
    /// No other thread may use the queue; the image can be copied from, and earlier submissions to
    /// the queue leave it ready to be presented, and the others ready to be copied from.
    pub(in crate::intercept::vk) unsafe fn read(
        &mut self,
        driver: &Driver,
        queue: Queue,
        (index, image, beside): (usize, vk::Image, &[vk::Image]),
        waits: &[vk::Semaphore],
        stamp: Stamp,
    ) -> VkResult<Option<vk::Semaphore>> {
        let Some(&copied) = self.copied.get(index) else { return Ok(None) };
        if self.next - self.oldest == FRAMES {
            publishing::left_out();
            return Ok(None);
        }
        let functions = &driver.functions;
        let transfer = &mut self.transfers[self.next % FRAMES];
        let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: as promised; the device has finished the earlier work of this transfer.
        unsafe {
            functions.begin_command_buffer(transfer.commands, &once)?;
            barrier(driver, transfer.commands, image, PRESENTED, COPIED_FROM);
            for region in &self.regions {
                let from = region.beside.map_or(Some(image), |number| beside.get(number).copied());
                if let Some(from) = from {
                    let (layout, copy) = (COPIED_FROM.layout, [region.copy]);
                    functions.cmd_copy_image_to_buffer(transfer.commands, from, layout, transfer.buffer, &copy);
                }
            }
            barrier(driver, transfer.commands, image, COPIED_FROM, PRESENTED);
            let seen = vk::MemoryBarrier::default()
                .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
                .dst_access_mask(vk::AccessFlags::HOST_READ);
            let (before, after) = (vk::PipelineStageFlags::TRANSFER, vk::PipelineStageFlags::HOST);
            let flags = vk::DependencyFlags::empty();
            functions.cmd_pipeline_barrier(transfer.commands, before, after, flags, &[seen], &[], &[]);
            functions.end_command_buffer(transfer.commands)?;
            let (buffers, signals) = ([transfer.commands], [copied]);
            let stages = vec![vk::PipelineStageFlags::ALL_COMMANDS; waits.len()];
            let work = vk::SubmitInfo::default()
                .wait_semaphores(waits)
                .wait_dst_stage_mask(&stages)
                .command_buffers(&buffers)
                .signal_semaphores(&signals);
            functions.reset_fences(&[transfer.done])?;
            functions.queue_submit(queue.handle, &[work], transfer.done)?;
        }
        transfer.stamp = stamp;
        self.next += 1;
        Ok(Some(copied))
    }

    /// Publishes the frames that the device has copied; `all`: also waits for the others.
    pub(in crate::intercept::vk) fn publish(&mut self, driver: &Driver, all: bool) {
        let functions = &driver.functions;
        while self.oldest < self.next {
            let transfer = &self.transfers[self.oldest % FRAMES];
            // SAFETY: a fence of Cupola that was submitted.
            let done = unsafe {
                match all {
                    true => functions.wait_for_fences(&[transfer.done], true, LONGEST_WAIT).is_ok(),
                    false => functions.get_fence_status(transfer.done).unwrap_or(false),
                }
            };
            if !done {
                return;
            }
            // SAFETY: memory of that size that stays mapped; the device has finished writing it.
            let bytes = unsafe {
                std::slice::from_raw_parts(std::ptr::with_exposed_provenance::<u8>(transfer.bytes), self.bytes)
            };
            let (shapes, regions, row) = (&self.shapes, &self.regions, &mut self.row);
            let formats = (self.format, self.published);
            publishing::publish(shapes, transfer.stamp, |pictures| {
                write(pictures, shapes, regions, bytes, (formats, row))
            });
            self.oldest += 1;
        }
    }

    /// # Safety
    /// The device must be live; presentations that wait for its semaphores must be over.
    pub(in crate::intercept::vk) unsafe fn destroy(&mut self, driver: &Driver) {
        self.publish(driver, true);
        let functions = &driver.functions;
        // SAFETY: as promised; destroying null objects does nothing.
        unsafe {
            for transfer in std::mem::take(&mut self.transfers) {
                functions.destroy_fence(transfer.done, None);
                functions.destroy_command_pool(transfer.pool, None);
                functions.destroy_buffer(transfer.buffer, None);
                functions.free_memory(transfer.memory, None);
            }
            self.copied.drain(..).for_each(|semaphore| functions.destroy_semaphore(semaphore, None));
        }
    }
}

fn write(
    pictures: &mut Pictures<'_>,
    shapes: &[Shape],
    regions: &[Region],
    bytes: &[u8],
    ((format, published), row): ((TexelFormat, Format), &mut Vec<u8>),
) {
    for (number, (shape, region)) in shapes.iter().zip(regions).enumerate() {
        let first = region.copy.buffer_offset as usize;
        let rows = bytes[first..].chunks_exact(shape.size.0 as usize * format.size());
        for (y, texels) in (0..shape.size.1).zip(rows) {
            row.clear();
            match (format, published) {
                (TexelFormat::Rgba8, Format::Rgba8) | (TexelFormat::Rgba16, Format::Rgba16) => {
                    pictures.row(number, y, texels);
                    continue;
                }
                (_, Format::Rgba16) => {
                    let colors = texels.chunks_exact(format.size()).map(|texel| format.deep_color(texel));
                    let pixels = colors.flat_map(|[red, green, blue]| [red, green, blue, u16::MAX]);
                    row.extend(pixels.flat_map(u16::to_ne_bytes));
                }
                (TexelFormat::Bgra8, _) => {
                    row.extend(
                        texels.as_chunks::<4>().0.iter().flat_map(|[blue, green, red, _]| [*red, *green, *blue, 255]),
                    );
                }
                _ => {
                    let colors = texels.chunks_exact(format.size()).map(|texel| format.color(texel));
                    row.extend(colors.flat_map(|[red, green, blue]| [red, green, blue, 255]));
                }
            }
            pictures.row(number, y, row);
        }
    }
}
