//! Stand-in images for a swapchain, an atlas for each, and the command buffers that make the
//! window's picture of them.

use crate::backend::vk::{COLOR, SourceImage, TargetImage, VkBackend};
use crate::correct::UpperLeftRect;
use crate::error::{Error, ErrorKind, Result};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::Queue;
use crate::intercept::vk::state::driver::own_image::{
    ANYTHING, COLOR_LAYER, COPIED_FROM, COPIED_TO, OwnImage, PRESENTED, barrier, color_view,
};
use crate::intercept::vk::state::swapchains::{PictureSource, Slot, StandIn};
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::intercept::vk::state::views::division_counter::Counter;
use crate::intercept::vk::state::views::view_target::{ATLAS_FLAGS, ATLAS_USAGE, ViewTarget};
use crate::lock::Lock;
use ash::vk;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

impl PictureSource {
    /// Whether it needs the correction, not only copies.
    fn corrects(self) -> bool {
        matches!(self, Self::Panel | Self::Views)
    }
}

/// Nanoseconds that the last picture of an image may take. A device that takes longer hangs.
const LONGEST_WAIT: u64 = 60_000_000_000;

/// Error for an object that the driver refuses.
fn refused(what: &str) -> impl Fn(vk::Result) -> Error + '_ {
    move |result| Error::new(ErrorKind::Graphics, format!("the driver refuses {what}: {result}"))
}

fn missing(index: usize) -> Error {
    Error::new(ErrorKind::Internal, format!("the swapchain has no image {index}"))
}

/// The format with the same bits that converts nothing.
pub fn plain_format(format: vk::Format) -> vk::Format {
    match format {
        vk::Format::B8G8R8A8_SRGB => vk::Format::B8G8R8A8_UNORM,
        vk::Format::R8G8B8A8_SRGB => vk::Format::R8G8B8A8_UNORM,
        vk::Format::A8B8G8R8_SRGB_PACK32 => vk::Format::A8B8G8R8_UNORM_PACK32,
        other => other,
    }
}

impl StandIn {
    /// For the swapchain that the driver made after `info`, with its `real` images. `timed`: it is
    /// measured how long the device takes.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where the driver refuses something.
    ///
    /// # Safety
    /// The device must be live, and the images of that swapchain.
    pub unsafe fn new(
        device: &Device,
        info: &vk::SwapchainCreateInfoKHR<'_>,
        real: &[vk::Image],
        layout: Arc<AtlasLayout>,
        timed: bool,
    ) -> Result<Self> {
        let mut stand_in = Self {
            layout,
            real: real.to_vec(),
            targets: Vec::new(),
            between: None,
            beside: Vec::new(),
            beside_images: Vec::new(),
            slots: Vec::new(),
            backend: VkBackend::new(&device.driver.api),
            format: plain_format(info.image_format),
            family: u32::MAX,
            pool: vk::CommandPool::null(),
            uploaded: false,
            timed,
        };
        // SAFETY: as promised; after a failure what was made is destroyed.
        unsafe {
            match stand_in.build(device, info) {
                Ok(()) => Ok(stand_in),
                Err(error) => {
                    stand_in.destroy(device);
                    Err(error)
                }
            }
        }
    }

    /// # Safety
    /// As for [`StandIn::new`].
    unsafe fn build(&mut self, device: &Device, info: &vk::SwapchainCreateInfoKHR<'_>) -> Result<()> {
        let plain = plain_format(info.image_format);
        let same = vk::ComponentMapping::default();
        let opaque = vk::ComponentMapping { a: vk::ComponentSwizzle::ONE, ..same };
        // SAFETY: as promised; everything is kept in `self` as soon as it is made.
        unsafe {
            for _ in 0..self.real.len() {
                let given = given_image(device, info).map_err(refused("an image for the program"))?;
                let atlas = atlas_image(device, info, self.layout.atlas).map_err(refused("an image for the views"));
                let atlas = atlas.inspect_err(|_| given.destroy(&device.driver))?;
                let layout = Arc::clone(&self.layout);
                let target = Arc::new(ViewTarget::of_window(layout, given.image, atlas.image));
                device.images.show(given.image, info.image_format, Arc::clone(&target));
                device.images.declare(given.image, info.image_usage);
                device.swapchains.note_target(info.image_format, Arc::clone(&target));
                self.slots.push(Slot {
                    given,
                    atlas,
                    target,
                    views: Default::default(),
                    ready: vk::Semaphore::null(),
                    done: vk::Fence::null(),
                    commands: Default::default(),
                    pending: false,
                    timed: None,
                });
                let Some(slot) = self.slots.last_mut() else { continue };
                for (view, components) in slot.views.iter_mut().zip([same, opaque]) {
                    *view = atlas.view(&device.driver, plain, components).map_err(refused("a view of an image"))?;
                }
                let semaphore = vk::SemaphoreCreateInfo::default();
                slot.ready =
                    device.driver.functions.create_semaphore(&semaphore, None).map_err(refused("a semaphore"))?;
                let fence = vk::FenceCreateInfo::default();
                slot.done = device.driver.functions.create_fence(&fence, None).map_err(refused("a fence"))?;
            }
            if plain == info.image_format {
                for image in &self.real {
                    let view =
                        color_view(&device.driver, *image, plain, same).map_err(refused("a view of the window"))?;
                    self.targets.push(view);
                }
            } else {
                let between = own_target(device, plain, info.image_extent).map_err(refused("an image"))?;
                self.between = Some(between);
                self.targets.push(between.view(&device.driver, plain, same).map_err(refused("a view of an image"))?);
            }
            for output in &self.layout.session.rig().beside {
                let (width, height) = output.size.unwrap_or_default();
                let image = own_target(device, plain, vk::Extent2D { width, height }).map_err(refused("an image"))?;
                self.beside.push((image, vk::ImageView::null()));
                self.beside_images.push(image.image);
                let view = image.view(&device.driver, plain, same).map_err(refused("a view of an image"))?;
                if let Some(last) = self.beside.last_mut() {
                    last.1 = view;
                }
            }
        }
        let mut backend = std::mem::replace(&mut self.backend, VkBackend::new(&device.driver.api));
        let prepared = self.prepare(&mut backend, &self.layout);
        self.backend = backend;
        prepared
    }

    /// Makes a backend ready to correct by a plan whose views lie as those of this stand-in image.
    fn prepare(&self, backend: &mut VkBackend, layout: &AtlasLayout) -> Result<()> {
        backend.prepare(&layout.plan, true, self.format)?;
        backend.set_sources(&self.sources(self.format))?;
        backend.set_targets(&self.target_images(self.format))
    }

    /// Corrects by another plan from the next picture on, with the same views in the same window.
    /// On an error everything stays.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where the driver refuses something.
    ///
    /// # Safety
    /// The device must be live, and no other thread may present this swapchain meanwhile.
    pub unsafe fn adopt(&mut self, device: &Device, layout: Arc<AtlasLayout>) -> Result<()> {
        let mut backend = VkBackend::new(&device.driver.api);
        let prepared = self.prepare(&mut backend, &layout);
        // SAFETY: as promised; the device has finished with what is destroyed.
        unsafe {
            self.wait(device);
            if let Err(error) = prepared {
                backend.destroy();
                return Err(error);
            }
            self.backend.destroy();
            device.driver.functions.destroy_command_pool(std::mem::take(&mut self.pool), None);
        }
        // The old backend's times are gone with it.
        self.slots.iter_mut().for_each(|slot| slot.timed = None);
        // Commands are recorded anew with the next pool.
        (self.backend, self.layout, self.family, self.uploaded) = (backend, layout, u32::MAX, false);
        Ok(())
    }

    /// Which of the [`StandIn::sources`] the correction of image `index` reads.
    fn source_of(&self, index: usize, show: PictureSource) -> usize {
        2 * index + usize::from(show == PictureSource::Panel && self.covers())
    }

    /// Whether the program's picture on the panel covers the views.
    fn covers(&self) -> bool {
        self.layout.flat_place() == self.layout.panel
    }

    /// The atlases: twice each, as they are and as if they covered everything.
    fn sources(&self, format: vk::Format) -> Vec<SourceImage> {
        let drawn = (PRESENTED.layout, vk::PipelineStageFlags::ALL_COMMANDS, vk::AccessFlags::MEMORY_WRITE);
        let copied = (COPIED_TO.layout, vk::PipelineStageFlags::TRANSFER, COPIED_TO.access);
        let source = |image, view, (layout, stages, access)| SourceImage {
            image,
            view,
            format,
            extent: self.layout.atlas,
            layout,
            stages,
            access,
        };
        self.slots
            .iter()
            .flat_map(|slot| {
                let image = slot.atlas.image;
                [source(image, slot.views[0], drawn), source(image, slot.views[1], copied)]
            })
            .collect()
    }

    fn target_images(&self, format: vk::Format) -> Vec<TargetImage> {
        let none = (vk::PipelineStageFlags::empty(), vk::AccessFlags::empty());
        let copy = (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_READ);
        let (final_layout, around) = match self.between {
            Some(_) => (COPIED_FROM.layout, copy),
            None => (PRESENTED.layout, none),
        };
        let images = self.between.iter().map(|own| own.image).chain(self.real.iter().copied());
        let target = |(image, &view)| TargetImage {
            image,
            view,
            format,
            extent: self.layout.window,
            initial_layout: vk::ImageLayout::UNDEFINED,
            final_layout,
            before: around,
            after: around,
        };
        let beside = self.beside.iter().zip(&self.layout.session.rig().beside);
        let beside = beside.map(|((own, view), output)| TargetImage {
            final_layout: COPIED_FROM.layout,
            extent: output.size.unwrap_or_default(),
            before: copy,
            after: copy,
            ..target((own.image, view))
        });
        images.zip(&self.targets).map(target).chain(beside).collect()
    }

    /// The image that the program has as number `index`.
    pub fn given(&self, index: usize) -> Option<vk::Image> {
        self.slots.get(index).map(|slot| slot.given.image)
    }

    /// The atlas of image `index`.
    pub fn atlas(&self, index: usize) -> Option<vk::Image> {
        self.slots.get(index).map(|slot| slot.atlas.image)
    }

    /// Whether the latest frame in image `index` is in the views.
    pub fn in_views(&self, index: usize) -> bool {
        self.slots.get(index).is_some_and(|slot| slot.target.in_views.load(Ordering::Relaxed))
    }

    /// Makes the window's picture `index` on a queue of a family, after `waits`. Returns the
    /// semaphore that says that it can be presented.
    ///
    /// Waits until the last picture of this image is done, 60 seconds at most. Normally it is
    /// done: the window system has handed the image out again.
    ///
    /// # Errors
    /// The driver's; and where the family cannot draw. Nothing was submitted then.
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
        // SAFETY: as promised; the command buffer is recorded, and not pending any more.
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

    /// The command buffer that makes the window's picture `index`, for queues of `family`; recorded
    /// at first.
    ///
    /// # Errors
    /// The driver's; and where the family cannot draw.
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
                // The first one also fills masks and tables, which is done once.
                self.uploaded = true;
            } else if let Some(slot) = self.slots.get_mut(index) {
                slot.commands[show as usize] = buffer;
            }
            Ok(buffer)
        }
    }

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
        let functions = &device.driver.functions;
        let (width, height) = self.layout.window;
        let whole = vk::Extent3D { width, height, depth: 1 };
        let (given, atlas) = (slot.given.image, slot.atlas.image);
        let region = vk::ImageCopy::default().src_subresource(COLOR_LAYER).dst_subresource(COLOR_LAYER).extent(whole);
        // SAFETY: as promised; all images are live, and as large as is said.
        unsafe {
            let copy = |from, to, region| {
                functions.cmd_copy_image(buffer, from, COPIED_FROM.layout, to, COPIED_TO.layout, &[region])
            };
            if !show.corrects() {
                let (from, region) = match show {
                    PictureSource::Tile => {
                        (atlas, region.src_offset(self.layout.own().unwrap_or(self.layout.panel).offset()))
                    }
                    _ => (given, region),
                };
                barrier(&device.driver, buffer, from, PRESENTED, COPIED_FROM);
                barrier(&device.driver, buffer, real, ANYTHING, COPIED_TO);
                copy(from, real, region);
                barrier(&device.driver, buffer, real, COPIED_TO, PRESENTED);
                barrier(&device.driver, buffer, from, COPIED_FROM, PRESENTED);
                return Ok(());
            }
            if show == PictureSource::Panel {
                barrier(&device.driver, buffer, given, PRESENTED, COPIED_FROM);
                barrier(&device.driver, buffer, atlas, ANYTHING, COPIED_TO);
                let black = vk::ClearColorValue::default();
                functions.cmd_clear_color_image(buffer, atlas, COPIED_TO.layout, &black, &[COLOR]);
                barrier(&device.driver, buffer, atlas, COPIED_TO, COPIED_TO);
                copy(given, atlas, region.dst_offset(self.layout.flat_place().offset()));
                barrier(&device.driver, buffer, given, COPIED_FROM, PRESENTED);
                if !self.covers() {
                    barrier(&device.driver, buffer, atlas, COPIED_TO, PRESENTED);
                }
            }
            let outputs = self.layout.outputs.len();
            for (number, output) in self.layout.session.rig().beside.iter().enumerate().take(self.beside.len()) {
                let (width, height) = output.size.unwrap_or_default();
                let mut places = vec![UpperLeftRect::default(); outputs + number];
                places.push(UpperLeftRect::new(0, 0, width as i32, height as i32));
                let target = self.targets.len() + number;
                self.backend.record(buffer, self.source_of(index, show), target, &places)?;
            }
            let target = if self.between.is_some() { 0 } else { index };
            self.backend.record(buffer, self.source_of(index, show), target, &self.layout.outputs)?;
            if show == PictureSource::Panel && self.covers() {
                barrier(&device.driver, buffer, atlas, COPIED_TO, PRESENTED);
            }
            if let Some(between) = &self.between {
                barrier(&device.driver, buffer, real, ANYTHING, COPIED_TO);
                copy(between.image, real, region);
                barrier(&device.driver, buffer, real, COPIED_TO, PRESENTED);
            }
        }
        Ok(())
    }

    /// Waits until the device has done what was submitted.
    ///
    /// # Safety
    /// The device must be live.
    pub unsafe fn wait(&self, device: &Device) {
        let fences: Vec<vk::Fence> = self.slots.iter().filter(|slot| slot.pending).map(|slot| slot.done).collect();
        if !fences.is_empty() {
            // SAFETY: fences of ours that were submitted; a lost device ends the wait with an
            // error.
            let _ = unsafe { device.driver.functions.wait_for_fences(&fences, true, u64::MAX) };
        }
    }

    /// # Safety
    /// Presentations that wait for its semaphores must be over.
    pub unsafe fn destroy(&mut self, device: &Device) {
        let functions = &device.driver.functions;
        // SAFETY: as promised; destroying null objects does nothing.
        unsafe {
            self.wait(device);
            self.backend.destroy();
            functions.destroy_command_pool(std::mem::take(&mut self.pool), None);
            for view in self.targets.drain(..) {
                functions.destroy_image_view(view, None);
            }
            for slot in self.slots.drain(..) {
                functions.destroy_semaphore(slot.ready, None);
                functions.destroy_fence(slot.done, None);
                slot.views.iter().for_each(|view| functions.destroy_image_view(*view, None));
                device.images.forget_swapchain_image(slot.given.image);
                device.swapchains.forget_target(&slot.target);
                slot.atlas.destroy(&device.driver);
                slot.given.destroy(&device.driver);
            }
            if let Some(between) = self.between.take() {
                between.destroy(&device.driver);
            }
            self.beside_images.clear();
            for (image, view) in self.beside.drain(..) {
                functions.destroy_image_view(view, None);
                image.destroy(&device.driver);
            }
        }
    }
}

/// An image like those of the swapchain, in `size`.
fn like<'a>(info: &vk::SwapchainCreateInfoKHR<'a>, (width, height): (u32, u32)) -> vk::ImageCreateInfo<'a> {
    let mut image = vk::ImageCreateInfo::default()
        .image_type(vk::ImageType::TYPE_2D)
        .format(info.image_format)
        .extent(vk::Extent3D { width, height, depth: 1 })
        .mip_levels(1)
        .array_layers(1)
        .samples(vk::SampleCountFlags::TYPE_1)
        .tiling(vk::ImageTiling::OPTIMAL)
        .sharing_mode(info.image_sharing_mode);
    image.queue_family_index_count = info.queue_family_index_count;
    image.p_queue_family_indices = info.p_queue_family_indices;
    image
}

/// An image for the program in the place of a real one.
///
/// # Safety
/// The device must be live.
unsafe fn given_image(device: &Device, info: &vk::SwapchainCreateInfoKHR<'_>) -> ash::prelude::VkResult<OwnImage> {
    let mutable = info.flags.contains(vk::SwapchainCreateFlagsKHR::MUTABLE_FORMAT);
    let flags = vk::ImageCreateFlags::MUTABLE_FORMAT | vk::ImageCreateFlags::EXTENDED_USAGE;
    let image = like(info, (info.image_extent.width, info.image_extent.height))
        .flags(if mutable { flags } else { vk::ImageCreateFlags::empty() })
        .usage(info.image_usage | vk::ImageUsageFlags::TRANSFER_SRC);
    // SAFETY: as promised.
    unsafe { OwnImage::new(&device.driver, &image) }
}

/// An image for the views; the program's render passes can draw into it, and the correction reads
/// it.
///
/// # Safety
/// The device must be live.
unsafe fn atlas_image(
    device: &Device,
    info: &vk::SwapchainCreateInfoKHR<'_>,
    size: (u32, u32),
) -> ash::prelude::VkResult<OwnImage> {
    let image = like(info, size).flags(ATLAS_FLAGS).usage(ATLAS_USAGE);
    // SAFETY: as promised.
    unsafe { OwnImage::new(&device.driver, &image) }
}

/// # Safety
/// The device must be live.
unsafe fn own_target(
    device: &Device,
    format: vk::Format,
    vk::Extent2D { width, height }: vk::Extent2D,
) -> ash::prelude::VkResult<OwnImage> {
    let image = vk::ImageCreateInfo::default()
        .image_type(vk::ImageType::TYPE_2D)
        .format(format)
        .extent(vk::Extent3D { width, height, depth: 1 })
        .mip_levels(1)
        .array_layers(1)
        .samples(vk::SampleCountFlags::TYPE_1)
        .usage(vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC);
    // SAFETY: as promised.
    unsafe { OwnImage::new(&device.driver, &image) }
}
