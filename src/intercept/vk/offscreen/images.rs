//! Images of the program, and the twins that stand for them while views are drawn.
//!
//! A swapchain's image has an atlas as its twin, and so has an image that holds a scene on its way to the window. What a
//! pass draws to together with them (depth, samples) gets a twin as large as the atlas. [`scenes`] has what is done with
//! images that may hold a scene, [`following`] what becomes of them when the window gets other views.

use crate::intercept::vk::commands::recording::Settled;
use crate::intercept::vk::descriptors::sets;
use crate::intercept::vk::layer::device::Device;
use crate::intercept::vk::layer::hooks::hooks;
use crate::intercept::vk::layer::pnext::in_chain;
use crate::intercept::vk::offscreen::scene_graph::{self, Made};
use crate::intercept::vk::offscreen::scenes;
use crate::intercept::vk::swapchain::atlas_layout::Layout;
use crate::intercept::vk::swapchain::own_image::OwnImage;
use ash::vk;
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// What atlases of scenes can be used for beside what the program's image can.
pub const ATLAS_COPIES: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::TRANSFER_SRC.as_raw() | vk::ImageUsageFlags::TRANSFER_DST.as_raw(),
);

/// An image of a swapchain, or one that holds a scene on its way to the window.
pub struct Shown {
    /// Where in the atlas everything is.
    pub layout: Arc<Layout>,
    /// The program's image.
    pub given: vk::Image,
    /// The atlas.
    pub atlas: vk::Image,
    /// It is a swapchain's.
    pub window: bool,
    /// The program's image can be copied to.
    pub copied_to: bool,
    /// The latest frame is in the atlas, not in the program's picture.
    pub in_views: AtomicBool,
    /// Of a scene that shaders sample: an image for each view.
    pub prints: Vec<OwnImage>,
    /// How often the program's own image was drawn to since the views are.
    pub(super) missed: AtomicU32,
}

impl Shown {
    /// A swapchain's image, with its atlas.
    pub fn of_window(layout: Arc<Layout>, given: vk::Image, atlas: vk::Image) -> Self {
        Self {
            layout,
            given,
            atlas,
            window: true,
            copied_to: false,
            in_views: false.into(),
            prints: Vec::new(),
            missed: 0.into(),
        }
    }

    /// Commands for the program's own image ran; whether that is so again and again.
    pub fn was_missed(&self) -> bool {
        !self.window && self.missed.fetch_add(1, Ordering::Relaxed) > scene_graph::PATIENCE
    }
}

/// What is known of an image.
pub(super) struct Image {
    pub(super) flags: vk::ImageCreateFlags,
    pub(super) kind: vk::ImageType,
    pub(super) format: vk::Format,
    pub(super) size: (u32, u32),
    pub(super) mip_levels: u32,
    pub(super) layers: u32,
    pub(super) samples: vk::SampleCountFlags,
    pub(super) usage: vk::ImageUsageFlags,
    /// The layout that was recorded last.
    pub(super) layout: vk::ImageLayout,
    /// Shaders read it.
    pub(super) described: bool,
    pub(super) shown: Option<Arc<Shown>>,
    pub(super) twins: Vec<((u32, u32), OwnImage)>,
}

/// What is known of an image's view.
pub(super) struct View {
    pub(super) image: vk::Image,
    pub(super) kind: vk::ImageViewType,
    pub(super) format: vk::Format,
    pub(super) components: vk::ComponentMapping,
    pub(super) range: vk::ImageSubresourceRange,
    /// Twins, by the image that they are views of.
    pub(super) twins: Vec<(vk::Image, vk::ImageView)>,
}

/// An image of ours that has to be brought into a layout before anything is submitted.
#[derive(Clone, Copy)]
pub struct Pending {
    /// The image.
    pub image: vk::Image,
    /// The layout that the program believes it to be in.
    pub layout: vk::ImageLayout,
    /// What it has.
    pub aspects: vk::ImageAspectFlags,
}

/// Images and their views.
#[derive(Default)]
pub struct Images {
    pub(super) images: Mutex<HashMap<vk::Image, Image>>,
    pub(super) views: Mutex<HashMap<vk::ImageView, View>>,
    pub(super) pending: Mutex<Vec<Pending>>,
    /// What the program asked for, of images that can be used for more.
    declared: Mutex<HashMap<vk::Image, vk::ImageUsageFlags>>,
    /// Some image may hold a scene.
    pub(super) candidates: AtomicBool,
    /// The size of the latest window.
    pub(super) window: Mutex<Option<(u32, u32)>>,
    /// Kinds of images that were found to hold a scene: after a change of size they are known at once.
    pub(super) scenes: Mutex<Vec<scenes::Kind>>,
    /// What scenes were drawn by before, as long as recorded commands use it.
    pub(super) retired: Mutex<Vec<Arc<Shown>>>,
}

/// What a format has.
pub fn aspects(format: vk::Format) -> vk::ImageAspectFlags {
    use vk::{Format as F, ImageAspectFlags as A};
    match format {
        F::D16_UNORM | F::X8_D24_UNORM_PACK32 | F::D32_SFLOAT => A::DEPTH,
        F::S8_UINT => A::STENCIL,
        F::D16_UNORM_S8_UINT | F::D24_UNORM_S8_UINT | F::D32_SFLOAT_S8_UINT => A::DEPTH | A::STENCIL,
        _ => A::COLOR,
    }
}

impl Images {
    /// The swapchain's image that is seen through a view.
    pub fn shown(&self, view: vk::ImageView) -> Option<Arc<Shown>> {
        let image = self.views.lock().unwrap_or_else(PoisonError::into_inner).get(&view)?.image;
        self.shown_image(image)
    }

    /// The swapchain's image.
    pub fn shown_image(&self, image: vk::Image) -> Option<Arc<Shown>> {
        self.images.lock().unwrap_or_else(PoisonError::into_inner).get(&image)?.shown.clone()
    }

    /// The program has `image` in the place of a swapchain's. It is brought into the layout in which passes leave it:
    /// those that draw to the atlas do not change it.
    pub fn show(&self, image: vk::Image, format: vk::Format, shown: Arc<Shown>) {
        let new = Image {
            flags: vk::ImageCreateFlags::empty(),
            kind: vk::ImageType::TYPE_2D,
            format,
            size: shown.layout.window,
            mip_levels: 1,
            layers: 1,
            samples: vk::SampleCountFlags::TYPE_1,
            usage: vk::ImageUsageFlags::empty(),
            layout: vk::ImageLayout::UNDEFINED,
            described: false,
            shown: Some(shown),
            twins: Vec::new(),
        };
        *self.window.lock().unwrap_or_else(PoisonError::into_inner) = Some(new.size);
        self.images.lock().unwrap_or_else(PoisonError::into_inner).insert(image, new);
        let layout = vk::ImageLayout::PRESENT_SRC_KHR;
        let pending = Pending { image, layout, aspects: vk::ImageAspectFlags::COLOR };
        self.pending.lock().unwrap_or_else(PoisonError::into_inner).push(pending);
    }

    /// The program asked for `usage` only; its views of the image are for no more, as those who compare it expect.
    pub fn declare(&self, image: vk::Image, usage: vk::ImageUsageFlags) {
        self.declared.lock().unwrap_or_else(PoisonError::into_inner).insert(image, usage);
    }

    /// An image of a swapchain is gone.
    pub fn hide(&self, image: vk::Image) {
        self.declared.lock().unwrap_or_else(PoisonError::into_inner).remove(&image);
        self.images.lock().unwrap_or_else(PoisonError::into_inner).remove(&image);
        self.pending.lock().unwrap_or_else(PoisonError::into_inner).retain(|pending| pending.image != image);
    }

    /// Format and samples of what a view shows.
    pub fn kind(&self, view: vk::ImageView) -> Option<(vk::Format, vk::SampleCountFlags)> {
        let (image, format) = {
            let views = self.views.lock().unwrap_or_else(PoisonError::into_inner);
            views.get(&view).map(|view| (view.image, view.format))?
        };
        self.images.lock().unwrap_or_else(PoisonError::into_inner).get(&image).map(|image| (format, image.samples))
    }

    /// A shader can read the image of a view, by a descriptor of this `kind`: what it shows must not be drawn to a twin in its
    /// place, unless it is read as an attachment, which has a twin as well.
    pub fn described(&self, device: &Device, view: vk::ImageView, kind: vk::DescriptorType) {
        let attachment = kind == vk::DescriptorType::INPUT_ATTACHMENT;
        let image = self.views.lock().unwrap_or_else(PoisonError::into_inner).get(&view).map(|view| view.image);
        let Some(image) = image else { return };
        let mut images = self.images.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(state) = images.get_mut(&image) else { return };
        state.described |= !attachment;
        if !(sets::is_sampled(kind) && state.is_single()) && state.may_hold_scene() {
            device.paths.leads(image, Made::Elsewhere);
        }
        // Of a scene there are prints.
        let drawn = state.shown.as_ref().map_or(!attachment && !state.twins.is_empty(), |shown| shown.window);
        drop(images);
        if drawn {
            device.give_up("its shaders read what it draws together with the window");
        }
    }

    /// The twins of an image, whose layouts follow the image's.
    pub fn twins(&self, image: vk::Image) -> Vec<vk::Image> {
        let images = self.images.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(state) = images.get(&image) else { return Vec::new() };
        let twins = state.twins.iter().map(|(_, twin)| twin.image);
        // The atlas of a scene is among the twins.
        let window = state.shown.iter().filter(|shown| shown.window);
        window.map(|shown| shown.atlas).chain(twins).collect()
    }

    /// The program recorded that an image changes its layout.
    pub fn moved(&self, image: vk::Image, layout: vk::ImageLayout) {
        if let Some(state) = self.images.lock().unwrap_or_else(PoisonError::into_inner).get_mut(&image) {
            state.layout = layout;
        }
    }

    /// A pass would have brought an image into a layout, but draws to its twin. What has to be brought there in its place.
    pub fn settle(&self, image: vk::Image, layout: vk::ImageLayout) -> Option<Settled> {
        let mut images = self.images.lock().unwrap_or_else(PoisonError::into_inner);
        let state = images.get_mut(&image).filter(|state| state.layout != layout)?;
        state.layout = layout;
        Some(Settled { image, aspects: aspects(state.format), layout })
    }

    /// The image of a view.
    pub fn of(&self, view: vk::ImageView) -> Option<vk::Image> {
        self.views.lock().unwrap_or_else(PoisonError::into_inner).get(&view).map(|view| view.image)
    }

    /// What has to be done before the next submission.
    pub fn take_pending(&self) -> Vec<Pending> {
        std::mem::take(&mut self.pending.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The view of the twin of a view's image, for passes into the atlas of `layout`.
    ///
    /// # Errors
    /// Why there is none.
    pub fn twin(&self, device: &Device, view: vk::ImageView, layout: &Layout) -> Result<vk::ImageView, String> {
        let (image, twins) = {
            let views = self.views.lock().unwrap_or_else(PoisonError::into_inner);
            let state = views.get(&view).ok_or("it draws to an image view that is not known")?;
            let single = [vk::ImageViewType::TYPE_2D].contains(&state.kind)
                && state.range.base_mip_level == 0
                && state.range.base_array_layer == 0;
            if !single {
                return Err("it draws to layers or levels of images together with the window".to_owned());
            }
            (state.image, state.twins.clone())
        };
        let refused = |error: vk::Result| format!("the driver refuses an image: {error}");
        let twin = self.twin_image(device, image, layout, false)?;
        if let Some((_, known)) = twins.iter().find(|(image, _)| *image == twin) {
            return Ok(*known);
        }
        let info = {
            let views = self.views.lock().unwrap_or_else(PoisonError::into_inner);
            let state = views.get(&view).ok_or("an image view is gone")?;
            vk::ImageViewCreateInfo::default()
                .image(twin)
                .view_type(state.kind)
                .format(state.format)
                .components(state.components)
                .subresource_range(state.range)
        };
        // SAFETY: the twin is live and has the format and aspects of the program's image.
        let made = unsafe { device.functions.create_image_view(&info, None) }.map_err(refused)?;
        if let Some(state) = self.views.lock().unwrap_or_else(PoisonError::into_inner).get_mut(&view) {
            state.twins.push((twin, made));
        }
        Ok(made)
    }

    /// `scene`: it becomes the atlas of a scene.
    pub(super) fn twin_image(
        &self,
        device: &Device,
        image: vk::Image,
        layout: &Layout,
        scene: bool,
    ) -> Result<vk::Image, String> {
        let size = layout.atlas;
        let (info, format, believed) = {
            let images = self.images.lock().unwrap_or_else(PoisonError::into_inner);
            let state = images.get(&image).ok_or("it draws to an image that is not known")?;
            if let Some(shown) = &state.shown {
                let fits = shown.layout.atlas == size;
                return fits
                    .then_some(shown.atlas)
                    .ok_or_else(|| "it draws to windows of two sizes at once".to_owned());
            }
            if let Some((_, twin)) = state.twins.iter().find(|(of, _)| *of == size) {
                return Ok(twin.image);
            }
            if state.described && !scene {
                return Err("its shaders read what it draws together with the window".to_owned());
            }
            if state.kind != vk::ImageType::TYPE_2D || state.mip_levels != 1 || state.layers != 1 {
                return Err("it draws to layers or levels of images together with the window".to_owned());
            }
            let info = vk::ImageCreateInfo::default()
                .flags(state.flags)
                .image_type(state.kind)
                .format(state.format)
                .extent(vk::Extent3D { width: size.0, height: size.1, depth: 1 })
                .mip_levels(1)
                .array_layers(1)
                .samples(state.samples)
                .usage(state.usage | if scene { ATLAS_COPIES } else { vk::ImageUsageFlags::empty() });
            (info, state.format, state.layout)
        };
        // SAFETY: the device is live; the image differs from one of the program's in its size.
        let twin = unsafe { OwnImage::new(device, &info) };
        let twin = twin.map_err(|error| format!("the driver refuses an image of {} × {}: {error}", size.0, size.1))?;
        if believed != vk::ImageLayout::UNDEFINED {
            let pending = Pending { image: twin.image, layout: believed, aspects: aspects(format) };
            self.pending.lock().unwrap_or_else(PoisonError::into_inner).push(pending);
        }
        if let Some(state) = self.images.lock().unwrap_or_else(PoisonError::into_inner).get_mut(&image) {
            state.twins.push((size, twin));
        }
        Ok(twin.image)
    }
}

/// The first level and layer that an attachment's image needs to have no more of for a twin.
fn may_be_attachment(info: &vk::ImageCreateInfo<'_>) -> bool {
    use vk::ImageUsageFlags as U;
    info.usage.intersects(U::COLOR_ATTACHMENT | U::DEPTH_STENCIL_ATTACHMENT)
}

hooks! { images;
    [c"vkCreateImage"] create_image: vk::PFN_vkCreateImage = (
        device: vk::Device, info: *const vk::ImageCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, image: *mut vk::Image
    ) -> vk::Result { |state, next| {
        let result = next(device, info, allocator, image);
        let info = &*info;
        if result == vk::Result::SUCCESS && may_be_attachment(info) {
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
                described: false,
                shown: None,
                twins: Vec::new(),
            };
            state.images.add(&state, *image, new);
        }
        result
    } }
    [c"vkDestroyImage"] destroy_image: vk::PFN_vkDestroyImage = (
        device: vk::Device, image: vk::Image, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        let gone = state.images.images.lock().unwrap_or_else(PoisonError::into_inner).remove(&image);
        for (_, twin) in gone.iter().flat_map(|image| &image.twins) {
            state.images.pending.lock().unwrap_or_else(PoisonError::into_inner).retain(|p| p.image != twin.image);
            twin.destroy(&state);
        }
        if let Some(shown) = gone.as_ref().and_then(|image| image.shown.as_ref()) {
            state.images.destroy_prints(&state, shown);
        }
        state.paths.forget(image);
        next(device, image, allocator)
    } }
    [c"vkCreateImageView"] create_image_view: vk::PFN_vkCreateImageView = (
        device: vk::Device, info: *const vk::ImageViewCreateInfo<'_>, allocator: *const vk::AllocationCallbacks<'_>, view: *mut vk::ImageView
    ) -> vk::Result { |state, next| {
        let declared = state.images.declared.lock().unwrap_or_else(PoisonError::into_inner).get(&(*info).image).copied();
        let info = &*info;
        let said = in_chain::<vk::ImageViewUsageCreateInfo<'_>>(info.p_next, vk::StructureType::IMAGE_VIEW_USAGE_CREATE_INFO);
        let mut narrowed = vk::ImageViewUsageCreateInfo::default().usage(declared.unwrap_or_default());
        narrowed.p_next = info.p_next;
        let mut changed = *info;
        // Where usages are compared, the structure is known.
        if declared.is_some() && said.is_none() && state.next.framebuffers.compares_usage() {
            changed.p_next = std::ptr::from_ref(&narrowed).cast();
        }
        let result = next(device, &changed, allocator, view);
        if result == vk::Result::SUCCESS && state.corrects {
            let new = View {
                image: info.image,
                kind: info.view_type,
                format: info.format,
                components: info.components,
                range: info.subresource_range,
                twins: Vec::new(),
            };
            state.images.views.lock().unwrap_or_else(PoisonError::into_inner).insert(*view, new);
        }
        result
    } }
    [c"vkDestroyImageView"] destroy_image_view: vk::PFN_vkDestroyImageView = (
        device: vk::Device, view: vk::ImageView, allocator: *const vk::AllocationCallbacks<'_>
    ) { |state, next| {
        let gone = state.images.views.lock().unwrap_or_else(PoisonError::into_inner).remove(&view);
        for (_, twin) in gone.iter().flat_map(|view| &view.twins) {
            state.functions.destroy_image_view(*twin, None);
        }
        next(device, view, allocator)
    } }
}

/// Marks what the next picture of a swapchain's image is made of.
pub fn drawn(shown: &Shown, in_views: bool) {
    shown.in_views.store(in_views, Ordering::Relaxed);
}
