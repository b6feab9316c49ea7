//! Stand-in images for a swapchain, an atlas for each, and the images that the correction draws to.

use super::images::{atlas_image, deep_format, own_target, plain_format, program_image, refused};
use crate::backend::vk::{SourceImage, TargetImage, VkBackend};
use crate::error::Result;
use crate::intercept::process::{log, publishing, settings};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::own_image::{COPIED_FROM, COPIED_TO, OwnImage, PRESENTED, color_view};
use crate::intercept::vk::state::swapchains::{PictureSource, Slot, StandIn};
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::intercept::vk::state::views::view_target::ViewTarget;
use crate::runtime::session::Session;
use ash::vk;
use std::mem::{replace, take};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Returns the format that the correction writes for windows of this format.
fn target_format(device: &Device, format: vk::Format) -> vk::Format {
    let usual = plain_format(format);
    if !publishing::is_deep() {
        return usual;
    }
    match deep_format(&device.driver.api, format) {
        Some((deep, _)) => deep,
        None => {
            log::once("Vulkan: published pictures have no more bits than the window: the device cannot convert them");
            usual
        }
    }
}

impl StandIn {
    /// Makes the stand-in images for the swapchain that the driver made with `info`, with its
    /// `real` images. `timed`: the time of the device is measured.
    ///
    /// # Errors
    /// [`Graphics`](crate::error::ErrorKind::Graphics) if the driver refuses something.
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
            narrow: None,
            beside: Vec::new(),
            beside_images: Vec::new(),
            slots: Vec::new(),
            backend: VkBackend::new(&device.driver.api),
            format: plain_format(info.image_format),
            target_format: target_format(device, info.image_format),
            family: u32::MAX,
            pool: vk::CommandPool::null(),
            uploaded: false,
            timed,
        };
        // SAFETY: as promised; after a failure, the objects made so far are destroyed.
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
        // SAFETY: as promised.
        unsafe {
            for _ in 0..self.real.len() {
                self.add_slot(device, info)?;
            }
            self.add_targets(device, info)?;
            self.add_outputs_beside(device)?;
        }
        let mut backend = std::mem::replace(&mut self.backend, VkBackend::new(&device.driver.api));
        let prepared = self.prepare(&mut backend, &self.layout);
        self.backend = backend;
        prepared
    }

    /// Adds an image for the program, and the atlas for draws to it.
    ///
    /// # Safety
    /// As for [`StandIn::new`].
    unsafe fn add_slot(&mut self, device: &Device, info: &vk::SwapchainCreateInfoKHR<'_>) -> Result<()> {
        let same = vk::ComponentMapping::default();
        let opaque = vk::ComponentMapping { a: vk::ComponentSwizzle::ONE, ..same };
        // SAFETY: as promised; every object is stored in `self` as soon as it is made.
        unsafe {
            let given = program_image(device, info).map_err(refused("an image for the program"))?;
            let atlas = atlas_image(device, info, self.layout.atlas).map_err(refused("an image for the views"));
            let atlas = atlas.inspect_err(|_| given.destroy(&device.driver))?;
            let target = Arc::new(ViewTarget::of_window(Arc::clone(&self.layout), given.image, atlas.image));
            device.images.show(given.image, info.image_format, Arc::clone(&target));
            device.images.declare(given.image, info.image_usage);
            device.swapchains.note_target(info.image_format, Arc::clone(&target));
            let slot = self.slots.push_mut(Slot {
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
            for (view, components) in slot.views.iter_mut().zip([same, opaque]) {
                *view = atlas.view(&device.driver, self.format, components).map_err(refused("a view of an image"))?;
            }
            let functions = &device.driver.functions;
            let semaphore = vk::SemaphoreCreateInfo::default();
            slot.ready = functions.create_semaphore(&semaphore, None).map_err(refused("a semaphore"))?;
            let fence = vk::FenceCreateInfo::default();
            slot.done = functions.create_fence(&fence, None).map_err(refused("a fence"))?;
        }
        Ok(())
    }

    /// Adds the targets of the correction: the real images, or one image that is then copied to
    /// them, if their format converts values, or if pictures of 16 bits are published.
    ///
    /// # Safety
    /// As for [`StandIn::new`].
    unsafe fn add_targets(&mut self, device: &Device, info: &vk::SwapchainCreateInfoKHR<'_>) -> Result<()> {
        let same = vk::ComponentMapping::default();
        // SAFETY: as promised; every object is stored in `self` as soon as it is made.
        unsafe {
            if self.target_format == info.image_format {
                for image in &self.real {
                    let view = color_view(&device.driver, *image, self.format, same);
                    self.targets.push(view.map_err(refused("a view of the window"))?);
                }
            } else {
                let own = |format| own_target(device, format, info.image_extent).map_err(refused("an image"));
                let between = own(self.target_format)?;
                self.between = Some(between);
                if self.target_format != self.format {
                    self.narrow = Some(own(self.format)?);
                }
                let view = between.view(&device.driver, self.target_format, same);
                self.targets.push(view.map_err(refused("a view of an image"))?);
            }
        }
        Ok(())
    }

    /// Adds an image for each output outside of the window.
    ///
    /// # Safety
    /// As for [`StandIn::new`].
    unsafe fn add_outputs_beside(&mut self, device: &Device) -> Result<()> {
        for output in &self.layout.session.rig().beside {
            let (width, height) = output.size.unwrap_or_default();
            // SAFETY: as promised; every object is stored in `self` as soon as it is made.
            unsafe {
                let extent = vk::Extent2D { width, height };
                let image = own_target(device, self.target_format, extent).map_err(refused("an image"))?;
                let (_, view) = self.beside.push_mut((image, vk::ImageView::null()));
                self.beside_images.push(image.image);
                *view = image
                    .view(&device.driver, self.target_format, vk::ComponentMapping::default())
                    .map_err(refused("a view of an image"))?;
            }
        }
        self.beside_images.extend(self.deep().map(|between| between.image));
        Ok(())
    }

    /// The picture of the window in 16 bits, if such pictures are published.
    pub(super) fn deep(&self) -> Option<OwnImage> {
        self.between.filter(|_| self.narrow.is_some())
    }

    /// Prepares a backend to correct by a plan with the same positions of the views as in this
    /// stand-in image.
    fn prepare(&self, backend: &mut VkBackend, layout: &AtlasLayout) -> Result<()> {
        let has_panel = settings::settings().is_none_or(|settings| settings.overlay);
        backend.prepare(&layout.plan, has_panel, self.target_format)?;
        backend.set_sources(&self.sources(self.format))?;
        backend.set_targets(&self.target_images(self.target_format))
    }

    /// Corrects by another plan from the next picture on, with the same views in the same window.
    /// After an error the plan is the old one.
    ///
    /// # Errors
    /// [`Graphics`](crate::error::ErrorKind::Graphics) if the driver refuses something.
    ///
    /// # Safety
    /// The device must be live, and no other thread may present this swapchain meanwhile.
    pub unsafe fn adopt(&mut self, device: &Device, layout: Arc<AtlasLayout>) -> Result<()> {
        // SAFETY: as promised; the device has finished with the destroyed objects.
        unsafe {
            self.wait(device);
            device.driver.functions.destroy_command_pool(take(&mut self.pool), None);
        }
        // Commands are recorded again with the next pool. The times of the old ones are lost.
        self.slots.iter_mut().for_each(|slot| slot.timed = None);
        (self.family, self.uploaded) = (u32::MAX, false);
        // The same backend keeps the pipelines that both plans need.
        let mut backend = replace(&mut self.backend, VkBackend::new(&device.driver.api));
        let prepared = self.prepare(&mut backend, &layout);
        if prepared.is_err() {
            // If that fails as well, the next picture reports it.
            let _ = self.prepare(&mut backend, &self.layout);
        }
        self.backend = backend;
        prepared?;
        self.layout = layout;
        Ok(())
    }

    /// Sessions of the views that draws are issued to, and of the correction.
    pub fn sessions(&self) -> impl Iterator<Item = &Session> {
        self.slots.iter().map(|slot| &*slot.target.layout.session).chain([&*self.layout.session])
    }

    /// Returns the index among [`StandIn::sources`] that the correction of image `index` reads.
    pub(super) fn source_of(&self, index: usize, show: PictureSource) -> usize {
        2 * index + usize::from(show == PictureSource::Panel && self.covers())
    }

    /// True if the program's picture on the panel covers the views.
    pub(super) fn covers(&self) -> bool {
        self.layout.flat_place() == self.layout.panel
    }

    /// Returns two sources for each atlas: one with its own alpha, and one that is opaque.
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

    /// Returns image number `index` of the program.
    pub fn given(&self, index: usize) -> Option<vk::Image> {
        self.slots.get(index).map(|slot| slot.given.image)
    }

    /// Returns the atlas of image `index`.
    pub fn atlas(&self, index: usize) -> Option<vk::Image> {
        self.slots.get(index).map(|slot| slot.atlas.image)
    }

    /// True if the latest frame of image `index` was drawn to the views.
    pub fn in_views(&self, index: usize) -> bool {
        self.slots.get(index).is_some_and(|slot| slot.target.in_views.load(Ordering::Relaxed))
    }

    /// Waits until the device has finished the submitted work.
    ///
    /// # Safety
    /// The device must be live.
    pub unsafe fn wait(&self, device: &Device) {
        let fences: Vec<vk::Fence> = self.slots.iter().filter(|slot| slot.pending).map(|slot| slot.done).collect();
        if !fences.is_empty() {
            // SAFETY: fences of Cupola that were submitted; a lost device ends the wait with an
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
            for own in [self.between.take(), self.narrow.take()].into_iter().flatten() {
                own.destroy(&device.driver);
            }
            self.beside_images.clear();
            for (image, view) in self.beside.drain(..) {
                functions.destroy_image_view(view, None);
                image.destroy(&device.driver);
            }
        }
    }
}
