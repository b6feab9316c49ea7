//! Images of the program, and what stands for them while views are drawn.
//!
//! [`scene_graph`] notes which of them hold a scene on its way to the window, [`framebuffers`]
//! which of them a render pass draws to.

pub mod framebuffers;
pub mod scene_graph;

use crate::intercept::scene::viewport;
use crate::intercept::settings;
use crate::intercept::vk::state::driver::own_image::OwnImage;
use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect};
use crate::intercept::vk::state::views::view_target::{ATLAS_COPY_USAGE, ViewTarget};
use crate::lock::Lock;
use crate::rig::Duplicate;
use ash::vk;
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, Weak};

/// An image of the program.
pub(in crate::intercept::vk) struct Image {
    pub(in crate::intercept::vk) flags: vk::ImageCreateFlags,
    pub(in crate::intercept::vk) kind: vk::ImageType,
    pub(in crate::intercept::vk) format: vk::Format,
    pub(in crate::intercept::vk) size: (u32, u32),
    pub(in crate::intercept::vk) mip_levels: u32,
    pub(in crate::intercept::vk) layers: u32,
    pub(in crate::intercept::vk) samples: vk::SampleCountFlags,
    pub(in crate::intercept::vk) usage: vk::ImageUsageFlags,
    /// The layout that was recorded last.
    pub(in crate::intercept::vk) layout: vk::ImageLayout,
    /// That in which the commands leave it that were submitted last: they need not have been
    /// recorded last.
    pub(in crate::intercept::vk) submitted_layout: vk::ImageLayout,
    /// Shaders read it.
    pub(in crate::intercept::vk) described: bool,
    /// A pass with depth only drew to its atlas copy in its place.
    pub(in crate::intercept::vk) drawn_alone: bool,
    /// A pass had it as an attachment.
    pub(in crate::intercept::vk) attached: bool,
    /// So did a pass that drew to the window or to a scene.
    pub(in crate::intercept::vk) drawn_together: bool,
    /// Layout of the last of these passes, if no pass of the program's own and no copy to the image
    /// came later.
    pub(in crate::intercept::vk) drawn_in: Weak<AtlasLayout>,
    pub(in crate::intercept::vk) target: Option<Arc<ViewTarget>>,
    pub(in crate::intercept::vk) atlas_copies: Vec<((u32, u32), OwnImage)>,
}

/// A view of an image.
pub(in crate::intercept::vk) struct View {
    pub(in crate::intercept::vk) image: vk::Image,
    pub(in crate::intercept::vk) kind: vk::ImageViewType,
    pub(in crate::intercept::vk) format: vk::Format,
    pub(in crate::intercept::vk) components: vk::ComponentMapping,
    pub(in crate::intercept::vk) range: vk::ImageSubresourceRange,
    /// Its usage, if that is less than its image's.
    pub(in crate::intercept::vk) usage: Option<vk::ImageUsageFlags>,
    /// Atlas copies, by the image that they are views of.
    pub(in crate::intercept::vk) atlas_copies: Vec<(vk::Image, vk::ImageView)>,
}

/// An image of Cupola that has to be brought into a layout before anything is submitted.
#[derive(Clone, Copy)]
pub struct PendingLayout {
    /// The image.
    pub(in crate::intercept::vk) image: vk::Image,
    /// The layout that the program believes it to be in.
    pub(in crate::intercept::vk) layout: vk::ImageLayout,
    /// Its aspects.
    pub(in crate::intercept::vk) aspects: vk::ImageAspectFlags,
    /// Its colour is cleared first.
    pub(in crate::intercept::vk) cleared: bool,
    /// The image of the program whose content it gets, in the same layout, and the place for that.
    pub(in crate::intercept::vk) filled: Option<(vk::Image, AtlasRect)>,
}

/// Format, usage and samples of an image.
pub type ImageKind = (vk::Format, vk::ImageUsageFlags, vk::SampleCountFlags);

/// An image that was found to hold a scene.
#[derive(Clone, Copy, Debug)]
pub struct KnownScene {
    pub(in crate::intercept::vk) kind: ImageKind,
    pub(in crate::intercept::vk) size: (u32, u32),
    /// Size of the window at that time.
    pub(in crate::intercept::vk) window: (u32, u32),
}

impl KnownScene {
    /// True if an image of this kind and size is its counterpart for a window of another size.
    pub(in crate::intercept::vk) fn is_like(&self, kind: ImageKind, size: (u32, u32), window: (u32, u32)) -> bool {
        // Up to rounding to whole texels.
        let near = |size: u32, window: u32, own: u32, own_window: u32| {
            let [size, scaled] = [(size, own_window), (window, own)].map(|(a, b)| u64::from(a) * u64::from(b));
            size.abs_diff(scaled) <= u64::from(own_window)
        };
        self.kind == kind
            && near(size.0, window.0, self.size.0, self.window.0)
            && near(size.1, window.1, self.size.1, self.window.1)
    }
}

/// Images and their views.
#[derive(Default)]
pub struct Images {
    pub(in crate::intercept::vk) images: Mutex<HashMap<vk::Image, Image>>,
    pub(in crate::intercept::vk) views: Mutex<HashMap<vk::ImageView, View>>,
    pub(in crate::intercept::vk) pending: Mutex<Vec<PendingLayout>>,
    /// Usage that the program asked for, of images that can be used for more.
    pub(in crate::intercept::vk) declared: Mutex<HashMap<vk::Image, vk::ImageUsageFlags>>,
    /// Some image may hold a scene.
    pub(in crate::intercept::vk) candidates: AtomicBool,
    /// The size of the latest window.
    pub(in crate::intercept::vk) window: Mutex<Option<(u32, u32)>>,
    /// Images that were found to hold a scene: after a change of size, others like these are known
    /// at once.
    pub(in crate::intercept::vk) scenes: Mutex<Vec<KnownScene>>,
    /// Former targets of scenes, as long as recorded commands use them.
    pub(in crate::intercept::vk) retired: Mutex<Vec<Arc<ViewTarget>>>,
    /// Target that compute shaders write in the place of a window's images.
    pub(in crate::intercept::vk) of_window: Mutex<Option<Arc<ViewTarget>>>,
    /// Compute shaders make pictures of a scene: each view of an off-screen scene is as large as
    /// the program's image.
    pub(in crate::intercept::vk) even: AtomicBool,
    /// They make numbers of it, too: there is the program's own picture of an off-screen scene.
    pub(in crate::intercept::vk) own_read: AtomicBool,
}

/// True if an image has the shape of a window, in any size.
fn has_shape((width, height): (u32, u32), window: (u32, u32)) -> bool {
    viewport::has_shape(width.into(), height.into(), window)
}

/// Aspects of a format.
pub fn aspects(format: vk::Format) -> vk::ImageAspectFlags {
    use vk::{Format as F, ImageAspectFlags as A};
    match format {
        F::D16_UNORM | F::X8_D24_UNORM_PACK32 | F::D32_SFLOAT => A::DEPTH,
        F::S8_UINT => A::STENCIL,
        F::D16_UNORM_S8_UINT | F::D24_UNORM_S8_UINT | F::D32_SFLOAT_S8_UINT => A::DEPTH | A::STENCIL,
        _ => A::COLOR,
    }
}

/// An image of the program that has to be brought into a layout.
#[derive(Clone, Copy, Debug)]
pub struct LayoutChange {
    /// The image.
    pub(in crate::intercept::vk) image: vk::Image,
    /// Its aspects.
    pub(in crate::intercept::vk) aspects: vk::ImageAspectFlags,
    /// The layout.
    pub(in crate::intercept::vk) layout: vk::ImageLayout,
}

impl Image {
    /// True if it may hold a scene on its way to the window.
    pub(in crate::intercept::vk) fn may_hold_scene(&self) -> bool {
        use vk::ImageUsageFlags as U;
        self.usage.intersects(U::COLOR_ATTACHMENT | U::DEPTH_STENCIL_ATTACHMENT | U::STORAGE)
            && self.usage.intersects(U::SAMPLED | U::TRANSFER_SRC | U::STORAGE)
            && self.kind == vk::ImageType::TYPE_2D
            && self.layers == 1
            && (self.mip_levels == 1 || !self.may_be_attached())
            && self.target.as_ref().is_none_or(|target| !target.window)
    }

    /// True if passes may draw to it. What only compute shaders write may have several levels.
    pub(in crate::intercept::vk) fn may_be_attached(&self) -> bool {
        use vk::ImageUsageFlags as U;
        self.usage.intersects(U::COLOR_ATTACHMENT | U::DEPTH_STENCIL_ATTACHMENT)
    }

    /// Usage of a copy of it that passes draw to in its place.
    pub(in crate::intercept::vk) fn atlas_copy_usage(&self) -> vk::ImageUsageFlags {
        if self.may_hold_scene() { self.usage | ATLAS_COPY_USAGE } else { self.usage }
    }

    /// True if it has one sample in each pixel: pictures with more cannot be copied into view
    /// copies.
    pub(in crate::intercept::vk) fn is_single(&self) -> bool {
        self.samples == vk::SampleCountFlags::TYPE_1
    }

    pub(in crate::intercept::vk) fn kind(&self) -> ImageKind {
        (self.format, self.usage, self.samples)
    }
}

impl Images {
    /// The swapchain's image that is seen through a view.
    pub fn target(&self, view: vk::ImageView) -> Option<Arc<ViewTarget>> {
        let image = self.views.locked().get(&view)?.image;
        self.target_of_image(image)
    }

    /// The swapchain's image.
    pub fn target_of_image(&self, image: vk::Image) -> Option<Arc<ViewTarget>> {
        self.images.locked().get(&image)?.target.clone()
    }

    /// The program has `image` in the place of a swapchain's. It is brought into the layout in
    /// which passes leave it: those that draw to the atlas do not change it.
    pub fn show(&self, image: vk::Image, format: vk::Format, target: Arc<ViewTarget>) {
        let new = Image {
            flags: vk::ImageCreateFlags::empty(),
            kind: vk::ImageType::TYPE_2D,
            format,
            size: target.layout.window,
            mip_levels: 1,
            layers: 1,
            samples: vk::SampleCountFlags::TYPE_1,
            usage: vk::ImageUsageFlags::empty(),
            layout: vk::ImageLayout::UNDEFINED,
            submitted_layout: vk::ImageLayout::UNDEFINED,
            described: false,
            drawn_alone: false,
            attached: false,
            drawn_together: false,
            drawn_in: Weak::new(),
            target: Some(target),
            atlas_copies: Vec::new(),
        };
        *self.window.locked() = Some(new.size);
        self.images.locked().insert(image, new);
        let layout = vk::ImageLayout::PRESENT_SRC_KHR;
        let pending =
            PendingLayout { image, layout, aspects: vk::ImageAspectFlags::COLOR, cleared: false, filled: None };
        self.pending.locked().push(pending);
    }

    /// The program asked for `usage` only; its views of the image are for no more, as those who
    /// compare it expect.
    pub fn declare(&self, image: vk::Image, usage: vk::ImageUsageFlags) {
        self.declared.locked().insert(image, usage);
    }

    /// An image of a swapchain is gone.
    pub fn forget_swapchain_image(&self, image: vk::Image) {
        self.declared.locked().remove(&image);
        self.images.locked().remove(&image);
        self.pending.locked().retain(|pending| pending.image != image);
    }

    /// Format and samples of what a view shows.
    pub fn kind(&self, view: vk::ImageView) -> Option<(vk::Format, vk::SampleCountFlags)> {
        let (image, format) = {
            let views = self.views.locked();
            views.get(&view).map(|view| (view.image, view.format))?
        };
        self.images.locked().get(&image).map(|image| (format, image.samples))
    }

    /// The atlas copies of an image, whose layouts follow the image's.
    pub fn atlas_copies(&self, image: vk::Image) -> Vec<vk::Image> {
        let images = self.images.locked();
        let Some(state) = images.get(&image) else { return Vec::new() };
        let atlas_copies = state.atlas_copies.iter().map(|(_, atlas_copy)| atlas_copy.image);
        // The atlas of a scene is among the atlas copies.
        let window = state.target.iter().filter(|target| target.window);
        window.map(|target| target.atlas).chain(atlas_copies).collect()
    }

    /// The program recorded that an image changes its layout. Whether the image is known.
    pub fn moved(&self, image: vk::Image, layout: vk::ImageLayout) -> bool {
        let mut images = self.images.locked();
        let state = images.get_mut(&image);
        state.map(|state| state.layout = layout).is_some()
    }

    /// Commands that take an image to a layout were submitted.
    pub fn submitted(&self, image: vk::Image, layout: vk::ImageLayout) {
        if let Some(state) = self.images.locked().get_mut(&image) {
            state.submitted_layout = layout;
        }
    }

    /// A pass would have brought an image into a layout, but draws to its atlas copy. What has to
    /// be brought there in its place.
    pub fn change_layout(&self, image: vk::Image, layout: vk::ImageLayout) -> Option<LayoutChange> {
        let mut images = self.images.locked();
        let state = images.get_mut(&image).filter(|state| state.layout != layout)?;
        state.layout = layout;
        Some(LayoutChange { image, aspects: aspects(state.format), layout })
    }

    /// The image of a view.
    pub fn of(&self, view: vk::ImageView) -> Option<vk::Image> {
        self.views.locked().get(&view).map(|view| view.image)
    }

    /// Takes the layouts that images have to be brought into before the next submission.
    pub fn take_pending(&self) -> Vec<PendingLayout> {
        std::mem::take(&mut self.pending.locked())
    }

    /// An image of Cupola that was to be brought into a layout before the next submission will be
    /// in the layout `found` then. Returns the image, its aspects, and the layout that it was to
    /// have.
    pub fn begins_in(
        &self,
        image: vk::Image,
        found: vk::ImageLayout,
    ) -> Option<(vk::Image, vk::ImageAspectFlags, vk::ImageLayout)> {
        let mut pending = self.pending.locked();
        let index = pending.iter().position(|pending| pending.image == image)?;
        let PendingLayout { aspects, layout, .. } = pending[index];
        match found == vk::ImageLayout::UNDEFINED {
            true => drop(pending.swap_remove(index)),
            false => pending[index].layout = found,
        }
        Some((image, aspects, layout))
    }

    /// True if some image may hold a scene.
    pub fn has_candidates(&self) -> bool {
        self.candidates.load(Ordering::Relaxed)
    }

    /// True if an image may hold a scene on its way to the window: it has the window's shape, and
    /// can be shown. Depths are shown by shaders that read them.
    pub fn is_candidate(&self, image: vk::Image) -> bool {
        let window = *self.window.locked();
        let images = self.images.locked();
        let fits = images.get(&image).is_some_and(|state| {
            let shown = state.described || aspects(state.format).contains(vk::ImageAspectFlags::COLOR);
            shown && state.may_hold_scene() && window.is_some_and(|window| has_shape(state.size, window))
        });
        fits && settings::settings().is_some_and(|settings| settings.rig.views.duplicate != Duplicate::Never)
    }

    /// True if an image is as large as perspective draws for the window need it, not one of a chain
    /// for light around what is bright.
    pub fn is_large(&self, image: vk::Image) -> bool {
        let (size, window) = (self.size(image), *self.window.locked());
        let wide = |((width, height), window)| viewport::has_shape_of_window(width, height, window);
        let of_images = size.map(|(width, height)| (i64::from(width), i64::from(height)));
        of_images.zip(window).is_some_and(wide)
    }

    /// A pass has this image as an attachment.
    pub fn attached(&self, image: vk::Image) {
        if let Some(state) = self.images.locked().get_mut(&image) {
            state.attached = true;
            state.drawn_in = Weak::new();
        }
    }

    /// A copy to the image was recorded: its content is the program's own.
    pub(in crate::intercept::vk) fn overwritten(&self, image: vk::Image) {
        if let Some(state) = self.images.locked().get_mut(&image) {
            state.drawn_in = Weak::new();
        }
    }

    /// Layout and atlas copy of an image that is drawn together with the window or a scene.
    pub(in crate::intercept::vk) fn drawn_in(&self, image: vk::Image) -> Option<(Arc<AtlasLayout>, vk::Image)> {
        let images = self.images.locked();
        let state = images.get(&image).filter(|state| state.target.is_none())?;
        let layout = state.drawn_in.upgrade()?;
        let (_, atlas_copy) = state.atlas_copies.iter().find(|(size, _)| *size == layout.atlas)?;
        Some((layout, atlas_copy.image))
    }

    /// True if passes draw to this image, and the program's own picture cannot be copied from their
    /// atlas.
    pub fn lacks_own_picture(&self, image: vk::Image) -> bool {
        let to = vk::ImageUsageFlags::TRANSFER_DST;
        self.images.locked().get(&image).is_some_and(|state| state.attached && !state.usage.contains(to))
    }

    /// True if a pass had this image as an attachment.
    pub fn is_attached(&self, image: vk::Image) -> bool {
        self.images.locked().get(&image).is_some_and(|state| state.attached)
    }

    /// The format of an image.
    pub fn format(&self, image: vk::Image) -> Option<vk::Format> {
        self.images.locked().get(&image).map(|state| state.format)
    }

    /// True if an image is as large as the window.
    pub fn has_size_of_window(&self, image: vk::Image) -> bool {
        self.size(image) == *self.window.locked()
    }

    /// The image of a view, if it may hold a scene.
    pub fn candidate_of(&self, view: vk::ImageView) -> Option<vk::Image> {
        let image = self.views.locked().get(&view)?.image;
        self.is_candidate(image).then_some(image)
    }

    /// The size of an image.
    pub fn size(&self, image: vk::Image) -> Option<(u32, u32)> {
        self.images.locked().get(&image).map(|state| state.size)
    }

    /// Usage of what passes draw to in the place of a view's image.
    pub fn atlas_copy_usage(&self, view: vk::ImageView) -> Option<vk::ImageUsageFlags> {
        let image = self.of(view)?;
        self.images.locked().get(&image).map(Image::atlas_copy_usage)
    }

    /// True if an image holds depths.
    pub fn is_depth(&self, image: vk::Image) -> bool {
        let images = self.images.locked();
        images.get(&image).is_some_and(|state| !aspects(state.format).contains(vk::ImageAspectFlags::COLOR))
    }

    /// True if shaders read an image whose atlas copy a pass to the window or to a scene drew to.
    pub fn is_read_and_drawn_together(&self, image: vk::Image) -> bool {
        let images = self.images.locked();
        images.get(&image).is_some_and(|state| state.described && state.drawn_together && state.target.is_none())
    }

    /// An image's atlas copy of this size, if it has one.
    pub fn atlas_copy_of_size(&self, image: vk::Image, size: (u32, u32)) -> Option<vk::Image> {
        let images = self.images.locked();
        images.get(&image)?.atlas_copies.iter().find(|(of, _)| *of == size).map(|(_, atlas_copy)| atlas_copy.image)
    }

    /// The images that hold a scene and are drawn for each view.
    pub fn duplicated(&self) -> impl Iterator<Item = vk::Image> {
        let images = self.images.locked();
        let of_scene = |target: &Arc<ViewTarget>| !target.window;
        let all: Vec<_> = images
            .iter()
            .filter(|(_, state)| state.target.as_ref().is_some_and(of_scene))
            .map(|(image, _)| *image)
            .collect();
        all.into_iter()
    }

    /// The scene that an image holds, if it is drawn for each view.
    pub fn scene(&self, image: vk::Image) -> Option<Arc<ViewTarget>> {
        self.target_of_image(image).filter(|target| !target.window)
    }

    /// True if a scene's image is drawn by another layout by now.
    pub fn is_retired(&self, target: &Arc<ViewTarget>) -> bool {
        !target.window && self.scene(target.given).is_some_and(|now| !Arc::ptr_eq(&now, target))
    }
}

/// Views of the view copies of a scene.
pub struct ViewCopies {
    /// The scene; what has its place may get the same handles later.
    pub(in crate::intercept::vk) of: Weak<ViewTarget>,
    /// One for each view of the rig.
    pub(in crate::intercept::vk) views: Vec<vk::ImageView>,
    /// The layout that shaders find them in.
    pub(in crate::intercept::vk) layout: vk::ImageLayout,
}

impl ViewCopies {
    /// The same image for each of `count` views.
    pub fn same(view: vk::ImageView, count: usize) -> Self {
        Self { of: Weak::new(), views: vec![view; count], layout: vk::ImageLayout::UNDEFINED }
    }
}

impl PartialEq for ViewCopies {
    fn eq(&self, other: &Self) -> bool {
        Weak::ptr_eq(&self.of, &other.of) && self.views == other.views
    }
}

#[cfg(test)]
mod tests {
    use super::KnownScene;
    use ash::vk;

    #[test]
    fn images_have_counterparts_in_windows_of_other_sizes() {
        let of_usage = |usage| (vk::Format::R8G8B8A8_UNORM, usage, vk::SampleCountFlags::TYPE_1);
        let (kind, other) = (of_usage(vk::ImageUsageFlags::SAMPLED), of_usage(vk::ImageUsageFlags::TRANSFER_SRC));
        let half = KnownScene { kind, size: (320, 180), window: (640, 360) };
        for (size, window) in [((320, 180), (640, 360)), ((400, 300), (800, 600)), ((401, 226), (801, 451))] {
            assert!(half.is_like(kind, size, window), "{size:?} {window:?}");
            assert!(!half.is_like(other, size, window), "{size:?} {window:?}");
        }
        for (size, window) in [((640, 360), (640, 360)), ((200, 150), (800, 600)), ((400, 320), (800, 600))] {
            assert!(!half.is_like(kind, size, window), "{size:?} {window:?}");
        }
    }
}
