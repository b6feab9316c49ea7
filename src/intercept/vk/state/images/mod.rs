//! Images of the program, and the images that replace them while views are drawn.
//!
//! [`scene_graph`] notes which images hold a scene on its way to the window. [`framebuffers`] notes
//! which images a render pass draws to, [`coverage`] how much of the window a draw fills. `image`
//! holds the types, `layouts` follows layouts.

pub mod coverage;
pub mod framebuffers;
mod image;
mod layouts;
pub mod scene_graph;

pub(in crate::intercept::vk) use image::{Image, View};
pub use image::{ImageKind, KnownScene, LayoutChange, PendingLayout, ViewCopies, aspects};

use crate::correct::LowerLeftRect;
use crate::intercept::process::settings;
use crate::intercept::scene::viewport;
use crate::intercept::scene::viewport::parts::Parts;
use crate::intercept::vk::state::images::coverage::Coverage;
use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect};
use crate::intercept::vk::state::views::view_target::ViewTarget;
use crate::lock::Lock;
use crate::rig::Duplicate;
use ash::vk;
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, Weak};

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
    /// Parts of this window that images fill, between widgets.
    pub(in crate::intercept::vk) parts: Mutex<Parts>,
    /// Draws to the window that sample images of another shape.
    pub(in crate::intercept::vk) coverage: Coverage,
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
        if self.window.locked().replace(new.size) != Some(new.size) {
            self.parts.locked().clear();
        }
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

    /// Returns the image of a view.
    pub fn of(&self, view: vk::ImageView) -> Option<vk::Image> {
        self.views.locked().get(&view).map(|view| view.image)
    }

    /// True if any image may hold a scene.
    pub fn has_candidates(&self) -> bool {
        self.candidates.load(Ordering::Relaxed)
    }

    /// True if an image was seen in a small part of the window. It is examined only for the reason
    /// why it is flat.
    pub fn is_shown_small(&self, image: vk::Image) -> bool {
        self.coverage.small.locked().contains(&image)
    }

    /// True if an image has the shape of the window.
    pub fn is_window_shaped(&self, image: vk::Image) -> bool {
        let window = *self.window.locked();
        self.size(image).zip(window).is_some_and(|(size, window)| viewport::has_shape(size, window))
    }

    /// True if an image may be a scene in a part of the window: passes draw to it, it has colours,
    /// and it has another shape than the window.
    pub fn may_be_shown_in_part(&self, image: vk::Image) -> bool {
        let drawn = self.images.locked().get(&image).is_some_and(|state| {
            let colours = aspects(state.format).contains(vk::ImageAspectFlags::COLOR);
            colours && state.may_be_attached() && state.may_hold_scene()
        });
        drawn && !self.is_window_shaped(image)
    }

    /// True if an image of this size may be a scene that fills this large part of a window: it has
    /// the part's shape. Windows that show the program's own picture need no scene.
    pub fn may_fill_part(&self, size: (u32, u32), part: AtlasRect, window: &AtlasLayout) -> bool {
        let (rect, whole) = (LowerLeftRect::from(part), LowerLeftRect::of_size(window.window));
        rect != whole
            && whole.contains(rect)
            && rect.is_most_of(window.window)
            && viewport::has_shape(size, rect.size())
            && window.views.iter().all(|view| !view.own_lens)
    }

    /// Notes that an image fills a part of the window. Returns whether this is new.
    pub fn note_part(&self, part: LowerLeftRect) -> bool {
        self.parts.locked().note(part)
    }

    /// True if a picture of this size has the shape of the window, or of a part of it that images
    /// fill.
    fn has_shown_shape(&self, size: (u32, u32)) -> bool {
        let of_window = self.window.locked().is_some_and(|window| viewport::has_shape(size, window));
        of_window || self.parts.locked().of_shape(size).is_some()
    }

    /// True if an image may hold a scene on its way to the window: it has the shape of the window or
    /// of a part that images fill, and can be displayed. A depth image can be displayed if shaders
    /// read it.
    pub fn is_candidate(&self, image: vk::Image) -> bool {
        let size = self.images.locked().get(&image).and_then(|state| {
            let shown = state.described || aspects(state.format).contains(vk::ImageAspectFlags::COLOR);
            (shown && state.may_hold_scene()).then_some(state.size)
        });
        let fits = size.is_some_and(|size| self.has_shown_shape(size) || self.is_shown_small(image));
        fits && settings::settings().is_some_and(|settings| settings.rig.views.duplicate != Duplicate::Never)
    }

    /// True if an image is large enough for perspective draws for the window. Small images of a
    /// blur around bright parts are not.
    pub fn is_large(&self, image: vk::Image) -> bool {
        let Some(size) = self.size(image) else { return false };
        let window = *self.window.locked();
        window.is_some_and(|window| viewport::has_shape_of_window(size, window))
            || self.parts.locked().of(size).is_some()
            || self.is_shown_small(image)
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

    /// True if an image is as large as the window, or as a part of it that images fill.
    pub fn has_size_of_window(&self, image: vk::Image) -> bool {
        let size = self.size(image);
        size == *self.window.locked() || size.is_some_and(|size| self.parts.locked().any_of_size(size))
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
