//! Images of the program, for the window and off screen, and the atlas copies that passes draw to
//! instead.
//!
//! A swapchain's image has an atlas, and so has an image that holds a scene on its way to the
//! window. Other attachments of the same pass (depth, samples) get a copy as large as the atlas.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::state::descriptors;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::own_image::OwnImage;
use crate::intercept::vk::state::driver::structures::in_chain;
use crate::intercept::vk::state::hooks::hooks;
use crate::intercept::vk::state::images::scene_graph::Made;
use crate::intercept::vk::state::images::{Image, Images, PendingLayout, View, aspects};
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::intercept::vk::state::views::view_target::ViewTarget;
use crate::lock::Lock;
use ash::vk;
use std::sync::{Arc, Weak};

/// Reason for flat drawing: shaders would read the program's own image, which does not hold what
/// was drawn to views.
pub const READ_TOGETHER: &str = "its shaders read images that it draws together with the window";

/// Reason for flat drawing: compute shaders write the window's image.
pub const WRITES_WINDOW: &str = "compute shaders draw to its window, and not from a picture of its scene";

/// Notes that a shader that cannot be followed may write these images. If it writes the window, the
/// program is shown flat.
pub(in crate::intercept::vk) fn note_window(device: &Device, stored: impl IntoIterator<Item = vk::ImageView>) {
    let images = stored.into_iter().filter_map(|view| device.images.of(view));
    if images.filter_map(|image| device.images.target_of_image(image)).any(|target| target.window) {
        device.show_flat(WRITES_WINDOW);
    }
}

impl Images {
    /// Notes that a shader can read the image of a view, by a descriptor of this `kind`. From then
    /// on the image must not be drawn to an atlas copy instead. Images read as attachments are an
    /// exception, because such a descriptor has an atlas copy as well.
    pub fn described(&self, device: &Device, view: vk::ImageView, kind: vk::DescriptorType) {
        let attachment = kind == vk::DescriptorType::INPUT_ATTACHMENT;
        let image = self.views.locked().get(&view).map(|view| view.image);
        let Some(image) = image else { return };
        let mut images = self.images.locked();
        let Some(state) = images.get_mut(&image) else { return };
        state.described |= !attachment;
        // The results of compute shaders that write images are noted when they run.
        let stored = kind == vk::DescriptorType::STORAGE_IMAGE;
        if !((descriptors::is_sampled(kind) || stored) && state.is_single()) && state.may_hold_scene() {
            device.scene_graph.note_made(image, Made::Elsewhere);
        }
        // A scene has view copies.
        let together = !state.atlas_copies.is_empty() && (state.drawn_together || !state.drawn_alone);
        let drawn = state.target.as_ref().map_or(!attachment && together, |target| target.window);
        drop(images);
        // A sampled image may be followed from the next frame on.
        let by_compute = stored && self.target_of_image(image).is_some_and(|target| target.window);
        if drawn && !by_compute && !((descriptors::is_sampled(kind) || stored) && self.is_candidate(image)) {
            device.show_flat(READ_TOGETHER);
        }
    }

    /// Returns the view of the atlas copy of a view's image, for passes into the atlas of `layout`.
    ///
    /// # Errors
    /// The reason why there is none.
    pub fn atlas_copy(
        &self,
        device: &Device,
        view: vk::ImageView,
        layout: &AtlasLayout,
    ) -> Result<vk::ImageView, Obstacle> {
        let (image, atlas_copies) = {
            let views = self.views.locked();
            let state = views.get(&view).ok_or("it draws to an image view that is not known")?;
            let single = [vk::ImageViewType::TYPE_2D].contains(&state.kind)
                && state.range.base_mip_level == 0
                && state.range.base_array_layer == 0;
            if !single {
                return Err("it draws to layers or levels of images together with the window".into());
            }
            (state.image, state.atlas_copies.clone())
        };
        let refused = |error: vk::Result| format!("the driver refuses an image: {error}");
        let atlas_copy = self.atlas_copy_image(device, image, layout, false)?;
        if let Some((_, known)) = atlas_copies.iter().find(|(image, _)| *image == atlas_copy) {
            return Ok(*known);
        }
        let info = {
            let views = self.views.locked();
            let state = views.get(&view).ok_or("an image view is gone")?;
            vk::ImageViewCreateInfo::default()
                .image(atlas_copy)
                .view_type(state.kind)
                .format(state.format)
                .components(state.components)
                .subresource_range(state.range)
        };
        // SAFETY: the atlas copy is live and has the format and aspects of the program's image.
        let made = unsafe { device.driver.functions.create_image_view(&info, None) }.map_err(refused)?;
        if let Some(state) = self.views.locked().get_mut(&view) {
            state.atlas_copies.push((atlas_copy, made));
        }
        Ok(made)
    }

    /// Returns the window that the depth images of a pass without colours belong to, if they are
    /// its only attachments. Such a pass is drawn for each view, like passes that draw to the
    /// window. Depth that shaders read belongs to no window.
    pub fn window_of_depth(&self, device: &Device, views: &[vk::ImageView]) -> Option<Arc<ViewTarget>> {
        let window = device.swapchains.latest_window().filter(|_| device.draws_views())?;
        let belongs = |state: &Image| {
            !aspects(state.format).contains(vk::ImageAspectFlags::COLOR)
                && state.size == window.layout.window
                && !state.described
        };
        let handles: Option<Vec<_>> = views.iter().map(|view| self.of(*view)).collect();
        let handles = handles.filter(|handles| !handles.is_empty())?;
        let mut images = self.images.locked();
        if !handles.iter().all(|image| images.get(image).is_some_and(belongs)) {
            return None;
        }
        for image in &handles {
            if let Some(state) = images.get_mut(image) {
                state.drawn_alone = true;
            }
        }
        Some(window)
    }

    /// Notes that a pass draws to the window or to a scene, with this layout, and to the images of
    /// these views.
    pub fn draws_together(
        &self,
        device: &Device,
        layout: &Arc<AtlasLayout>,
        views: impl IntoIterator<Item = vk::ImageView>,
    ) {
        for image in views.into_iter().filter_map(|view| self.of(view)) {
            if let Some(state) = self.images.locked().get_mut(&image) {
                state.drawn_together = true;
                state.attached = true;
                state.drawn_in = Arc::downgrade(layout);
            }
            if self.is_candidate(image) {
                device.scene_graph.note_scene(image);
            }
        }
    }

    /// Notes that a pass of the program's own continues to use the image of a view. If a pass with
    /// depth only drew the image for each view, its content is missing there.
    pub fn goes_on_with(&self, device: &Device, view: vk::ImageView) {
        let alone =
            self.of(view).is_some_and(|image| self.images.locked().get(&image).is_some_and(|state| state.drawn_alone));
        if alone {
            device.show_flat("it draws depth first, and uses it for other images than the window's");
        }
    }

    /// `scene`: the image becomes the atlas of a scene.
    pub(super) fn atlas_copy_image(
        &self,
        device: &Device,
        image: vk::Image,
        layout: &AtlasLayout,
        scene: bool,
    ) -> Result<vk::Image, Obstacle> {
        let size = layout.atlas;
        let candidate = scene || self.is_candidate(image);
        let (info, format, current, filled) = {
            let images = self.images.locked();
            let state = images.get(&image).ok_or("it draws to an image that is not known")?;
            if let Some(target) = &state.target {
                let fits = target.layout.atlas == size;
                return fits.then_some(target.atlas).ok_or_else(|| "it draws to windows of two sizes at once".into());
            }
            if let Some((_, atlas_copy)) = state.atlas_copies.iter().find(|(of, _)| *of == size) {
                return Ok(atlas_copy.image);
            }
            if state.described && !candidate {
                return Err(READ_TOGETHER.into());
            }
            if state.kind != vk::ImageType::TYPE_2D || state.mip_levels != 1 || state.layers != 1 {
                return Err("it draws to layers or levels of images together with the window".into());
            }
            let info = vk::ImageCreateInfo::default()
                .flags(state.flags)
                .image_type(state.kind)
                .format(state.format)
                .extent(vk::Extent3D { width: size.0, height: size.1, depth: 1 })
                .mip_levels(1)
                .array_layers(1)
                .samples(state.samples)
                .usage(state.atlas_copy_usage());
            // At the end of a frame the submitted layout is used, since commands may be recorded
            // ahead of their submission.
            let current = if scene { state.submitted_layout } else { state.layout };
            // The content that a scene had before it was found becomes the program's own picture.
            let place = layout.own().filter(|own| (own.width as u32, own.height as u32) == state.size && scene);
            let place = place.filter(|_| state.usage.contains(vk::ImageUsageFlags::TRANSFER_SRC));
            (info, state.format, current, place.map(|place| (image, place)))
        };
        // SAFETY: the device is live; the image differs from one of the program's in its size.
        let atlas_copy = unsafe { OwnImage::new(&device.driver, &info) };
        let atlas_copy =
            atlas_copy.map_err(|error| format!("the driver refuses an image of {} × {}: {error}", size.0, size.1))?;
        if current != vk::ImageLayout::UNDEFINED {
            let (image, aspects) = (atlas_copy.image, aspects(format));
            let pending = PendingLayout { image, layout: current, aspects, cleared: false, filled };
            self.pending.locked().push(pending);
        }
        if let Some(state) = self.images.locked().get_mut(&image) {
            state.atlas_copies.push((size, atlas_copy));
        }
        Ok(atlas_copy.image)
    }
}

/// True if the image may be an attachment, or be written by compute shaders.
fn may_be_drawn(info: &vk::ImageCreateInfo<'_>) -> bool {
    use vk::ImageUsageFlags as U;
    info.usage.intersects(U::COLOR_ATTACHMENT | U::DEPTH_STENCIL_ATTACHMENT | U::STORAGE)
}

hooks! {
    create_image = (
        device: vk::Device, info: *const vk::ImageCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, image: *mut vk::Image
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, image);
        let info = &*info;
        if result == vk::Result::SUCCESS && may_be_drawn(info) {
            let new = Image {
                flags: info.flags,
                kind: info.image_type,
                format: info.format,
                size: (info.extent.width, info.extent.height),
                mip_levels: info.mip_levels,
                layers: info.array_layers,
                samples: info.samples,
                usage: info.usage,
                layout: vk::ImageLayout::UNDEFINED,
                submitted_layout: vk::ImageLayout::UNDEFINED,
                described: false,
                drawn_alone: false,
                attached: false,
                drawn_together: false,
                drawn_in: Weak::new(),
                target: None,
                atlas_copies: Vec::new(),
            };
            state.images.add(&state, *image, new);
        }
        result
    } }
    destroy_image = (
        device: vk::Device, image: vk::Image, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        let gone = state.images.images.locked().remove(&image);
        for (_, atlas_copy) in gone.iter().flat_map(|image| &image.atlas_copies) {
            state.images.pending.locked().retain(|p| p.image != atlas_copy.image);
            atlas_copy.destroy(&state.driver);
        }
        if let Some(target) = gone.as_ref().and_then(|image| image.target.as_ref()) {
            state.images.destroy_view_copies(&state, target);
        }
        state.images.forget_coverage(image);
        state.scene_graph.forget(image);
        next(device, image, allocator)
    } }
    create_image_view = (
        device: vk::Device, info: *const vk::ImageViewCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, view: *mut vk::ImageView
    ) -> vk::Result { |state, next| {
        let declared = state.images.declared.locked().get(&(*info).image).copied();
        let info = &*info;
        let said = in_chain::<vk::ImageViewUsageCreateInfo<'_>>(info.p_next, vk::StructureType::IMAGE_VIEW_USAGE_CREATE_INFO);
        let mut narrowed = vk::ImageViewUsageCreateInfo::default().usage(declared.unwrap_or_default());
        narrowed.p_next = info.p_next;
        let mut changed = *info;
        // A driver with imageless framebuffers, which compare usages, knows this structure.
        if declared.is_some() && said.is_none() && state.next.compares_usage() {
            changed.p_next = std::ptr::from_ref(&narrowed).cast();
        }
        let result = next(device, &changed, allocator, view);
        if result == vk::Result::SUCCESS && state.role.corrects {
            let new = View {
                image: info.image,
                kind: info.view_type,
                format: info.format,
                components: info.components,
                range: info.subresource_range,
                usage: said.map(|said| said.usage),
                atlas_copies: Vec::new(),
            };
            state.images.views.locked().insert(*view, new);
        }
        result
    } }
    destroy_image_view = (
        device: vk::Device, view: vk::ImageView, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        let gone = state.images.views.locked().remove(&view);
        for (_, atlas_copy) in gone.iter().flat_map(|view| &view.atlas_copies) {
            state.driver.functions.destroy_image_view(*atlas_copy, None);
        }
        next(device, view, allocator)
    } }
}
