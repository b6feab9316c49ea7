//! The command buffers that make the window's picture from a stand-in image or its atlas, and the
//! submission of these command buffers.

use super::images::refused;
use crate::backend::vk::{COLOR, Use};
use crate::correct::UpperLeftRect;
use crate::error::{Error, ErrorKind, Result};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::Queue;
use crate::intercept::vk::state::driver::own_image::{
    ANYTHING, COLOR_LAYER, COPIED_FROM, COPIED_TO, PRESENTED, barrier,
};
use crate::intercept::vk::state::swapchains::{PictureSource, StandIn};
use crate::intercept::vk::state::views::division_counter::Counter;
use crate::lock::Lock;
use ash::vk;
use std::time::Duration;

impl PictureSource {
    /// True if it needs the correction, not only copies.
    fn corrects(self) -> bool {
        matches!(self, Self::Panel | Self::Views)
    }
}

/// Longest time for the last picture of an image, in nanoseconds. A device that takes longer hangs.
const LONGEST_WAIT: u64 = 60_000_000_000;

fn missing(index: usize) -> Error {
    Error::new(ErrorKind::Internal, format!("the swapchain has no image {index}"))
}

impl StandIn {
    /// Makes the window's picture `index` on a queue of a family, after `waits`. Returns the
    /// semaphore that is signalled when the picture can be presented.
    ///
    /// Waits until the last picture of this image is done, for 60 seconds at most. Normally it is
    /// done already, since the window system has returned the image.
    ///
    /// # Errors
    /// The driver's errors, or that the family cannot draw. Nothing is submitted then.
    ///
    /// # Safety
    /// No other thread may use the queue or present this swapchain meanwhile.
    pub unsafe fn submit(
        &mut self,
        device: &Device,
        queue: Queue,
        index: usize,
        show: PictureSource,
        waits: &[vk::Semaphore],
    ) -> Result<vk::Semaphore> {
        // SAFETY: as promised; the command buffer is recorded, and no longer pending.
        unsafe {
            let commands = [self.commands(device, queue.family, index, show)?];
            let source = self.source_of(index, show);
            let Some(slot) = self.slots.get_mut(index) else { return Err(missing(index)) };
            let (ready, stages) = ([slot.ready], vec![vk::PipelineStageFlags::ALL_COMMANDS; waits.len()]);
            let work = vk::SubmitInfo::default()
                .wait_semaphores(waits)
                .wait_dst_stage_mask(&stages)
                .command_buffers(&commands)
                .signal_semaphores(&ready);
            let functions = &device.driver.functions;
            if slot.pending {
                functions.wait_for_fences(&[slot.done], true, LONGEST_WAIT).map_err(refused("to wait"))?;
                if let Some(source) = slot.timed.take() {
                    let before = self.backend.timing().corrections;
                    self.backend.read_timing(source);
                    let timing = self.backend.timing();
                    if timing.corrections > before {
                        let time = Duration::from_nanos(timing.last as u64);
                        device.presented.times.locked().device_correction.add(time);
                    }
                }
                functions.reset_fences(&[slot.done]).map_err(refused("to wait"))?;
                slot.pending = false;
            }
            functions.queue_submit(queue.handle, &[work], slot.done).map_err(refused("work"))?;
            (slot.pending, slot.timed) = (true, (self.timed && show.corrects()).then_some(source));
            Ok(slot.ready)
        }
    }

    /// Returns the command buffer that makes the window's picture `index`, for queues of `family`.
    /// It is recorded when it is needed first.
    ///
    /// # Errors
    /// The driver's errors, or that the family cannot draw.
    ///
    /// # Safety
    /// No other thread may present this swapchain meanwhile.
    unsafe fn commands(
        &mut self,
        device: &Device,
        family: u32,
        index: usize,
        show: PictureSource,
    ) -> Result<vk::CommandBuffer> {
        let draws = device.driver.families.get(family as usize).is_some_and(|f| f.contains(vk::QueueFlags::GRAPHICS));
        if show.corrects() && !draws {
            return Err(Error::new(ErrorKind::Graphics, "the queue that presents cannot draw"));
        }
        // SAFETY: as promised; a pool is replaced after the device has finished with it.
        unsafe {
            if family != self.family {
                if self.pool != vk::CommandPool::null() {
                    self.wait(device);
                    device.driver.functions.destroy_command_pool(self.pool, None);
                }
                self.slots.iter_mut().for_each(|slot| slot.commands = Default::default());
                let pool = vk::CommandPoolCreateInfo::default().queue_family_index(family);
                self.pool =
                    device.driver.functions.create_command_pool(&pool, None).map_err(refused("command buffers"))?;
                self.family = family;
                if self.timed && draws {
                    self.backend.measure(2 * self.slots.len(), family)?;
                }
            }
            let recorded = self.slots.get(index).ok_or_else(|| missing(index))?.commands[show as usize];
            if recorded != vk::CommandBuffer::null() {
                return Ok(recorded);
            }
            let buffer = device.driver.command_buffer(self.pool).map_err(refused("a command buffer"))?;
            let begin = vk::CommandBufferBeginInfo::default();
            device.driver.functions.begin_command_buffer(buffer, &begin).map_err(refused("to record"))?;
            let fills = show.corrects() && !self.uploaded;
            self.record(device, buffer, index, show)?;
            if show.corrects() && device.role.vertices.counts {
                Counter::show(&device.driver, buffer);
            }
            device.driver.functions.end_command_buffer(buffer).map_err(refused("to record"))?;
            if fills {
                // The first command buffer also fills masks and tables, which must be done only
                // once.
                self.uploaded = true;
            } else if let Some(slot) = self.slots.get_mut(index) {
                slot.commands[show as usize] = buffer;
            }
            Ok(buffer)
        }
    }

    /// Records the commands that make the window's picture `index`.
    ///
    /// # Safety
    /// The command buffer is being recorded.
    unsafe fn record(
        &mut self,
        device: &Device,
        buffer: vk::CommandBuffer,
        index: usize,
        show: PictureSource,
    ) -> Result<()> {
        let (Some(slot), Some(&real)) = (self.slots.get(index), self.real.get(index)) else { return Ok(()) };
        let (given, atlas) = (slot.given.image, slot.atlas.image);
        let commands = Commands { device, buffer, window: self.layout.window };
        // SAFETY: as promised; all images are live and have the given sizes.
        unsafe {
            match show {
                PictureSource::Own => commands.show(given, real, vk::Offset3D::default()),
                PictureSource::Tile => {
                    let tile = self.layout.own().unwrap_or(self.layout.panel);
                    commands.show(atlas, real, tile.offset());
                }
                PictureSource::Views => self.record_correction(buffer, index, show)?,
                PictureSource::Panel => {
                    commands.show_on_panel(given, atlas, self.layout.flat_place().offset());
                    // If the picture covers the views, the correction reads the atlas in the layout
                    // of the copy.
                    if !self.covers() {
                        commands.barrier(atlas, COPIED_TO, PRESENTED);
                    }
                    self.record_correction(buffer, index, show)?;
                    if self.covers() {
                        commands.barrier(atlas, COPIED_TO, PRESENTED);
                    }
                }
            }
            match (self.between, self.narrow) {
                (Some(between), Some(narrow)) if show.corrects() => {
                    commands.barrier(narrow.image, ANYTHING, COPIED_TO);
                    commands.convert(between.image, narrow.image);
                    commands.barrier(narrow.image, COPIED_TO, COPIED_FROM);
                    commands.barrier(real, ANYTHING, COPIED_TO);
                    commands.copy(narrow.image, real, commands.whole());
                    commands.barrier(real, COPIED_TO, PRESENTED);
                }
                (Some(between), Some(narrow)) => {
                    commands.barrier(real, PRESENTED, COPIED_FROM);
                    commands.barrier(narrow.image, ANYTHING, COPIED_TO);
                    commands.copy(real, narrow.image, commands.whole());
                    commands.barrier(narrow.image, COPIED_TO, COPIED_FROM);
                    commands.barrier(between.image, ANYTHING, COPIED_TO);
                    commands.convert(narrow.image, between.image);
                    commands.barrier(between.image, COPIED_TO, COPIED_FROM);
                    commands.barrier(real, COPIED_FROM, PRESENTED);
                }
                (Some(between), None) if show.corrects() => {
                    commands.barrier(real, ANYTHING, COPIED_TO);
                    commands.copy(between.image, real, commands.whole());
                    commands.barrier(real, COPIED_TO, PRESENTED);
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Records the correction of the outputs in the window, and of those outside of it.
    ///
    /// # Safety
    /// The command buffer is being recorded.
    unsafe fn record_correction(&mut self, buffer: vk::CommandBuffer, index: usize, show: PictureSource) -> Result<()> {
        let (source, outputs) = (self.source_of(index, show), self.layout.outputs.len());
        for (number, output) in self.layout.session.rig().beside.iter().enumerate().take(self.beside.len()) {
            let (width, height) = output.size.unwrap_or_default();
            let mut places = vec![UpperLeftRect::default(); outputs + number];
            places.push(UpperLeftRect::new(0, 0, width as i32, height as i32));
            // SAFETY: as promised.
            unsafe { self.backend.record(buffer, source, self.targets.len() + number, &places)? };
        }
        let target = if self.between.is_some() { 0 } else { index };
        // SAFETY: as promised.
        unsafe { self.backend.record(buffer, source, target, &self.layout.outputs) }
    }
}

/// A command buffer that is being recorded for a window.
struct Commands<'a> {
    device: &'a Device,
    buffer: vk::CommandBuffer,
    window: (u32, u32),
}

impl Commands<'_> {
    /// Returns the region of the whole window, for a copy from image to image at the same position.
    fn whole(&self) -> vk::ImageCopy {
        let (width, height) = self.window;
        let extent = vk::Extent3D { width, height, depth: 1 };
        vk::ImageCopy::default().src_subresource(COLOR_LAYER).dst_subresource(COLOR_LAYER).extent(extent)
    }

    /// # Safety
    /// The command buffer is being recorded, and the image is live.
    unsafe fn barrier(&self, image: vk::Image, from: Use, to: Use) {
        // SAFETY: as promised.
        unsafe { barrier(&self.device.driver, self.buffer, image, from, to) };
    }

    /// Copies the whole window from an image of one format to one of another.
    ///
    /// # Safety
    /// As for [`Commands::copy`]; the device converts between the formats.
    unsafe fn convert(&self, from: vk::Image, to: vk::Image) {
        let (width, height) = self.window;
        let corners = [vk::Offset3D::default(), vk::Offset3D { x: width as i32, y: height as i32, z: 1 }];
        let region = vk::ImageBlit::default()
            .src_subresource(COLOR_LAYER)
            .src_offsets(corners)
            .dst_subresource(COLOR_LAYER)
            .dst_offsets(corners);
        let (functions, filter) = (&self.device.driver.functions, vk::Filter::NEAREST);
        let (read, written) = (COPIED_FROM.layout, COPIED_TO.layout);
        // SAFETY: as promised.
        unsafe { functions.cmd_blit_image(self.buffer, from, read, to, written, &[region], filter) };
    }

    /// # Safety
    /// The command buffer is being recorded; the images are live, in the layouts of copies, and
    /// contain the region.
    unsafe fn copy(&self, from: vk::Image, to: vk::Image, region: vk::ImageCopy) {
        let functions = &self.device.driver.functions;
        // SAFETY: as promised.
        unsafe {
            functions.cmd_copy_image(self.buffer, from, COPIED_FROM.layout, to, COPIED_TO.layout, &[region]);
        }
    }

    /// Copies the part of an image at `offset` to the real image.
    ///
    /// # Safety
    /// As for [`Commands::copy`], with images in the layout for presentation.
    unsafe fn show(&self, from: vk::Image, real: vk::Image, offset: vk::Offset3D) {
        // SAFETY: as promised.
        unsafe {
            self.barrier(from, PRESENTED, COPIED_FROM);
            self.barrier(real, ANYTHING, COPIED_TO);
            self.copy(from, real, self.whole().src_offset(offset));
            self.barrier(real, COPIED_TO, PRESENTED);
            self.barrier(from, COPIED_FROM, PRESENTED);
        }
    }

    /// Clears the atlas, and copies the program's image to the panel at `offset`. The atlas stays in
    /// the layout for copies.
    ///
    /// # Safety
    /// As for [`Commands::show`].
    unsafe fn show_on_panel(&self, given: vk::Image, atlas: vk::Image, offset: vk::Offset3D) {
        // SAFETY: as promised.
        unsafe {
            self.barrier(given, PRESENTED, COPIED_FROM);
            self.barrier(atlas, ANYTHING, COPIED_TO);
            let black = vk::ClearColorValue::default();
            let functions = &self.device.driver.functions;
            functions.cmd_clear_color_image(self.buffer, atlas, COPIED_TO.layout, &black, &[COLOR]);
            self.barrier(atlas, COPIED_TO, COPIED_TO);
            self.copy(given, atlas, self.whole().dst_offset(offset));
            self.barrier(given, COPIED_FROM, PRESENTED);
        }
    }
}
