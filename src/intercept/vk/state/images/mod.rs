//! Images of the program, and the images that replace them while views are drawn.
//!
//! [`scene_graph`] notes which images hold a scene on its way to the window. [`framebuffers`] notes
//! which images a render pass draws to.

pub mod framebuffers;
pub mod scene_graph;

use crate::intercept::process::settings;
use crate::intercept::scene::viewport;
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
    /// Layout after the last recorded command.
    pub(in crate::intercept::vk) layout: vk::ImageLayout,
    /// Layout after the last submitted commands, which need not be those that were recorded last.
    pub(in crate::intercept::vk) submitted_layout: vk::ImageLayout,
    /// True if shaders can read it.
    pub(in crate::intercept::vk) described: bool,
    /// True if a pass with depth only drew to its atlas copy instead.
    pub(in crate::intercept::vk) drawn_alone: bool,
    /// True if a pass had it as an attachment.
    pub(in crate::intercept::vk) attached: bool,
    /// True if a pass that drew to the window or to a scene had it as an attachment.
    pub(in crate::intercept::vk) drawn_together: bool,
    /// Layout of the last of these passes, if neither a pass of the program's own nor a copy to the
    /// image came later.
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
    /// Atlas copies of the view, by the image that they belong to.
    pub(in crate::intercept::vk) atlas_copies: Vec<(vk::Image, vk::ImageView)>,
}

/// An image of Cupola that must be changed to a layout before the next submission.
#[derive(Clone, Copy)]
pub struct PendingLayout {
    /// The image.
    pub(in crate::intercept::vk) image: vk::Image,
    /// The layout that the program expects it to have.
    pub(in crate::intercept::vk) layout: vk::ImageLayout,
    /// Its aspects.
    pub(in crate::intercept::vk) aspects: vk::ImageAspectFlags,
    /// True if its colour is cleared first.
    pub(in crate::intercept::vk) cleared: bool,
    /// The image of the program whose content is copied to it, in the same layout, and the
    /// rectangle for the copy.
    pub(in crate::intercept::vk) filled: Option<(vk::Image, AtlasRect)>,
}

/// Format, usage and samples of an image.
pub type ImageKind = (vk::Format, vk::ImageUsageFlags, vk::SampleCountFlags);

/// An image that was found to hold a scene.
#[derive(Clone, Copy, Debug)]
pub struct KnownScene {
    pub(in crate::intercept::vk) kind: ImageKind,
    pub(in crate::intercept::vk) size: (u32, u32),
    /// Size of the window when the image was found.
    pub(in crate::intercept::vk) window: (u32, u32),
}

impl KnownScene {
    /// True if an image of this kind and size corresponds to it in a window of another size.
    pub(in crate::intercept::vk) fn is_like(&self, kind: ImageKind, size: (u32, u32), window: (u32, u32)) -> bool {
        // Equal up to rounding to whole texels.
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
    /// Usage that the program requested, for images that have more.
    pub(in crate::intercept::vk) declared: Mutex<HashMap<vk::Image, vk::ImageUsageFlags>>,
    /// True if any image may hold a scene.
    pub(in crate::intercept::vk) candidates: AtomicBool,
    /// The size of the latest window.
    pub(in crate::intercept::vk) window: Mutex<Option<(u32, u32)>>,
    /// Images that were found to hold a scene. After a change of size, similar images are
    /// recognised at once.
    pub(in crate::intercept::vk) scenes: Mutex<Vec<KnownScene>>,
    /// Former targets of scenes, which are kept while recorded commands use them.
    pub(in crate::intercept::vk) retired: Mutex<Vec<Arc<ViewTarget>>>,
    /// Target that compute shaders write instead of a window's images.
    pub(in crate::intercept::vk) of_window: Mutex<Option<Arc<ViewTarget>>>,
    /// True if compute shaders make pictures of a scene. Each view of an off-screen scene is then
    /// as large as the program's image.
    pub(in crate::intercept::vk) even: AtomicBool,
    /// True if they also make numbers from it. Off-screen scenes then also have the program's own
    /// picture.
    pub(in crate::intercept::vk) own_read: AtomicBool,
}

/// True if an image has the shape of a window, at any size.
fn has_shape((width, height): (u32, u32), window: (u32, u32)) -> bool {
    viewport::has_shape(width.into(), height.into(), window)
}

/// Returns the aspects of a format.
pub fn aspects(format: vk::Format) -> vk::ImageAspectFlags {
    use vk::{Format as F, ImageAspectFlags as A};
    match format {
        F::D16_UNORM | F::X8_D24_UNORM_PACK32 | F::D32_SFLOAT => A::DEPTH,
        F::S8_UINT => A::STENCIL,
        F::D16_UNORM_S8_UINT | F::D24_UNORM_S8_UINT | F::D32_SFLOAT_S8_UINT => A::DEPTH | A::STENCIL,
        _ => A::COLOR,
    }
}

/// An image of the program whose layout must be changed.
#[derive(Clone, Copy, Debug)]
pub struct LayoutChange {
    /// The image.
    pub(in crate::intercept::vk) image: vk::Image,
    /// Its aspects.
    pub(in crate::intercept::vk) aspects: vk::ImageAspectFlags,
    /// The new layout.
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

    /// True if passes may draw to it. Images that only compute shaders write may have several
    /// levels.
    pub(in crate::intercept::vk) fn may_be_attached(&self) -> bool {
        use vk::ImageUsageFlags as U;
        self.usage.intersects(U::COLOR_ATTACHMENT | U::DEPTH_STENCIL_ATTACHMENT)
    }

    /// Returns the usage of its atlas copy.
    pub(in crate::intercept::vk) fn atlas_copy_usage(&self) -> vk::ImageUsageFlags {
        if self.may_hold_scene() { self.usage | ATLAS_COPY_USAGE } else { self.usage }
    }

    /// True if it has one sample per pixel. Images with more samples cannot be copied to view
    /// copies.
    pub(in crate::intercept::vk) fn is_single(&self) -> bool {
        self.samples == vk::SampleCountFlags::TYPE_1
    }

    pub(in crate::intercept::vk) fn kind(&self) -> ImageKind {
        (self.format, self.usage, self.samples)
    }
}

impl Images {
    /// Returns the target that the image of a view belongs to.
    pub fn target(&self, view: vk::ImageView) -> Option<Arc<ViewTarget>> {
        let image = self.views.locked().get(&view)?.image;
        self.target_of_image(image)
    }

    /// Returns the target that an image belongs to.
    pub fn target_of_image(&self, image: vk::Image) -> Option<Arc<ViewTarget>> {
        self.images.locked().get(&image)?.target.clone()
    }

    /// Notes that the program has `image` in place of a swapchain's. Its layout is changed to the
    /// one in which passes leave it, because passes to the atlas do not change it.
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

    /// Notes that the program requested only `usage`. Its views of the image get no more usage,
    /// since imageless framebuffers are compared with it.
    pub fn declare(&self, image: vk::Image, usage: vk::ImageUsageFlags) {
        self.declared.locked().insert(image, usage);
    }

    /// Forgets a destroyed image of a swapchain.
    pub fn forget_swapchain_image(&self, image: vk::Image) {
        self.declared.locked().remove(&image);
        self.images.locked().remove(&image);
        self.pending.locked().retain(|pending| pending.image != image);
    }

    /// Returns format and samples of a view.
    pub fn kind(&self, view: vk::ImageView) -> Option<(vk::Format, vk::SampleCountFlags)> {
        let (image, format) = {
            let views = self.views.locked();
            views.get(&view).map(|view| (view.image, view.format))?
        };
        self.images.locked().get(&image).map(|image| (format, image.samples))
    }

    /// Returns the atlas copies of an image. Their layouts follow the image's.
    pub fn atlas_copies(&self, image: vk::Image) -> Vec<vk::Image> {
        let images = self.images.locked();
        let Some(state) = images.get(&image) else { return Vec::new() };
        let atlas_copies = state.atlas_copies.iter().map(|(_, atlas_copy)| atlas_copy.image);
        // The atlas of a scene is among the atlas copies.
        let window = state.target.iter().filter(|target| target.window);
        window.map(|target| target.atlas).chain(atlas_copies).collect()
    }

    /// Notes a recorded change of an image's layout. Returns whether the image is known.
    pub fn moved(&self, image: vk::Image, layout: vk::ImageLayout) -> bool {
        let mut images = self.images.locked();
        let state = images.get_mut(&image);
        state.map(|state| state.layout = layout).is_some()
    }

    /// Notes that commands that change an image to a layout were submitted.
    pub fn submitted(&self, image: vk::Image, layout: vk::ImageLayout) {
        if let Some(state) = self.images.locked().get_mut(&image) {
            state.submitted_layout = layout;
        }
    }

    /// Notes that a pass would have changed an image to a layout, but draws to its atlas copy.
    /// Returns the change that has to be done instead.
    pub fn change_layout(&self, image: vk::Image, layout: vk::ImageLayout) -> Option<LayoutChange> {
        let mut images = self.images.locked();
        let state = images.get_mut(&image).filter(|state| state.layout != layout)?;
        state.layout = layout;
        Some(LayoutChange { image, aspects: aspects(state.format), layout })
    }

    /// Returns the image of a view.
    pub fn of(&self, view: vk::ImageView) -> Option<vk::Image> {
        self.views.locked().get(&view).map(|view| view.image)
    }

    /// Takes the layout changes that have to be done before the next submission.
    pub fn take_pending(&self) -> Vec<PendingLayout> {
        std::mem::take(&mut self.pending.locked())
    }

    /// Notes that an image of Cupola with a pending change of its layout will have the layout
    /// `found` instead. Returns the image, its aspects, and the layout of the pending change.
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

    /// True if any image may hold a scene.
    pub fn has_candidates(&self) -> bool {
        self.candidates.load(Ordering::Relaxed)
    }

    /// True if an image may hold a scene on its way to the window: it has the window's shape, and
    /// can be displayed. A depth image can be displayed if shaders read it.
    pub fn is_candidate(&self, image: vk::Image) -> bool {
        let window = *self.window.locked();
        let images = self.images.locked();
        let fits = images.get(&image).is_some_and(|state| {
            let shown = state.described || aspects(state.format).contains(vk::ImageAspectFlags::COLOR);
            shown && state.may_hold_scene() && window.is_some_and(|window| has_shape(state.size, window))
        });
        fits && settings::settings().is_some_and(|settings| settings.rig.views.duplicate != Duplicate::Never)
    }

    /// True if an image is large enough for perspective draws for the window. Small images of a
    /// blur around bright parts are not.
    pub fn is_large(&self, image: vk::Image) -> bool {
        let (size, window) = (self.size(image), *self.window.locked());
        let wide = |((width, height), window)| viewport::has_shape_of_window(width, height, window);
        let of_images = size.map(|(width, height)| (i64::from(width), i64::from(height)));
        of_images.zip(window).is_some_and(wide)
    }

    /// Notes that a pass has this image as an attachment.
    pub fn attached(&self, image: vk::Image) {
        if let Some(state) = self.images.locked().get_mut(&image) {
            state.attached = true;
            state.drawn_in = Weak::new();
        }
    }

    /// Notes a recorded copy to the image. Its content is the program's own from then on.
    pub(in crate::intercept::vk) fn overwritten(&self, image: vk::Image) {
        if let Some(state) = self.images.locked().get_mut(&image) {
            state.drawn_in = Weak::new();
        }
    }

    /// Returns layout and atlas copy of an image that is drawn together with the window or a scene.
    pub(in crate::intercept::vk) fn drawn_in(&self, image: vk::Image) -> Option<(Arc<AtlasLayout>, vk::Image)> {
        let images = self.images.locked();
        let state = images.get(&image).filter(|state| state.target.is_none())?;
        let layout = state.drawn_in.upgrade()?;
        let (_, atlas_copy) = state.atlas_copies.iter().find(|(size, _)| *size == layout.atlas)?;
        Some((layout, atlas_copy.image))
    }

    /// True if passes draw to this image, but the program's own picture cannot be copied from their
    /// atlas.
    pub fn lacks_own_picture(&self, image: vk::Image) -> bool {
        let to = vk::ImageUsageFlags::TRANSFER_DST;
        self.images.locked().get(&image).is_some_and(|state| state.attached && !state.usage.contains(to))
    }

    /// True if a pass had this image as an attachment.
    pub fn is_attached(&self, image: vk::Image) -> bool {
        self.images.locked().get(&image).is_some_and(|state| state.attached)
    }

    /// Returns the format of an image.
    pub fn format(&self, image: vk::Image) -> Option<vk::Format> {
        self.images.locked().get(&image).map(|state| state.format)
    }

    /// True if an image is as large as the window.
    pub fn has_size_of_window(&self, image: vk::Image) -> bool {
        self.size(image) == *self.window.locked()
    }

    /// Returns the image of a view, if it may hold a scene.
    pub fn candidate_of(&self, view: vk::ImageView) -> Option<vk::Image> {
        let image = self.views.locked().get(&view)?.image;
        self.is_candidate(image).then_some(image)
    }

    /// Returns the size of an image.
    pub fn size(&self, image: vk::Image) -> Option<(u32, u32)> {
        self.images.locked().get(&image).map(|state| state.size)
    }

    /// Returns the usage of the atlas copy of a view's image.
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

    /// Returns an image's atlas copy of this size, if it has one.
    pub fn atlas_copy_of_size(&self, image: vk::Image, size: (u32, u32)) -> Option<vk::Image> {
        let images = self.images.locked();
        images.get(&image)?.atlas_copies.iter().find(|(of, _)| *of == size).map(|(_, atlas_copy)| atlas_copy.image)
    }

    /// Returns the images that hold a scene and are drawn for each view.
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

    /// Returns the scene that an image holds, if it is drawn for each view.
    pub fn scene(&self, image: vk::Image) -> Option<Arc<ViewTarget>> {
        self.target_of_image(image).filter(|target| !target.window)
    }

    /// True if a scene's image has another target by now.
    pub fn is_retired(&self, target: &Arc<ViewTarget>) -> bool {
        !target.window && self.scene(target.given).is_some_and(|now| !Arc::ptr_eq(&now, target))
    }
}

/// Views of the view copies of a scene.
pub struct ViewCopies {
    /// The scene. It is compared, because new objects may get the same handles later.
    pub(in crate::intercept::vk) of: Weak<ViewTarget>,
    /// One image view for each view of the rig.
    pub(in crate::intercept::vk) views: Vec<vk::ImageView>,
    /// The layout in which shaders read them.
    pub(in crate::intercept::vk) layout: vk::ImageLayout,
}

impl ViewCopies {
    /// Returns the same image for each of `count` views.
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
