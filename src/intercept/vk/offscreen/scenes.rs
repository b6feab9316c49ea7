//! Images that hold a scene on its way to the window: their atlases and view copies.

use crate::intercept::process::settings;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::scene::viewport;
use crate::intercept::vk::offscreen::view_images::ViewImages;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::images::{Image, Images, KnownScene, ViewCopies, aspects};
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::intercept::vk::state::views::atlas_layout::AtlasRect;
use crate::intercept::vk::state::views::view_target::ViewTarget;
use crate::lock::Lock;
use crate::rig::Duplicate;
use ash::vk;
use std::sync::Arc;
use std::sync::atomic::Ordering;

impl Images {
    /// Adds an image of the program that can be drawn to.
    pub(super) fn add(&self, device: &Device, handle: vk::Image, image: Image) {
        let (kind, size, may) = (image.kind(), image.size, image.may_hold_scene());
        self.images.locked().insert(handle, image);
        if !may {
            return;
        }
        self.candidates.store(true, Ordering::Relaxed);
        let always = settings::settings().is_some_and(|settings| settings.rig.views.duplicate == Duplicate::Always);
        let is_known = |layout: &Arc<AtlasLayout>| {
            let scenes = self.scenes.locked();
            let mut kinds = scenes.iter().map(|scene| scene.kind);
            layout.window == size && (always || kinds.any(|known| known == kind))
                || scenes.iter().any(|scene| scene.is_like(kind, size, layout.window))
        };
        if let Some(layout) = device.swapchains.latest_layout().filter(is_known)
            && let Err(why) = self.duplicate(device, handle, &layout)
        {
            device.show_flat(why);
        }
    }

    /// Starts to draw an image for each view.
    ///
    /// # Errors
    /// The request that the driver refuses.
    pub fn duplicate(&self, device: &Device, image: vk::Image, layout: &Arc<AtlasLayout>) -> Result<(), Obstacle> {
        if self.target_of_image(image).is_some() {
            return Ok(());
        }
        let (kind, flags, described, size, levels) = {
            let images = self.images.locked();
            let Some(state) = images.get(&image) else { return Ok(()) };
            // Blits that change the size read these images, too.
            let scaled = state.size != layout.window && state.usage.contains(vk::ImageUsageFlags::TRANSFER_SRC);
            let read = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::STORAGE;
            let described = scaled || state.usage.intersects(read);
            (state.kind(), state.flags, described && state.is_single(), state.size, state.mip_levels)
        };
        let most = device.driver.greatest_image();
        let window = layout.window;
        let Some(layout) = &self.layout_of(layout, size, most) else { return Ok(()) };
        if layout.atlas.0.max(layout.atlas.1) > most {
            return Err("an image of its scene has no room for all views".into());
        }
        // The atlas copy is made as for any image that is drawn to. It becomes the atlas.
        let atlas = match levels {
            1 => self.atlas_copy_image(device, image, layout, true)?,
            // Nothing is drawn to it.
            _ => vk::Image::null(),
        };
        let tiles: Vec<AtlasRect> = layout.views.iter().map(|view| view.rect).filter(|_| described).collect();
        let ViewImages { view_copies, nothing, kept } =
            self.view_images(device, (&tiles, levels), flags, (kind.0, kind.1))?;
        let target = ViewTarget {
            layout: Arc::clone(layout),
            given: image,
            atlas,
            window: false,
            aspects: aspects(kind.0),
            copied_to: kind.1.contains(vk::ImageUsageFlags::TRANSFER_DST),
            in_views: false.into(),
            view_copies,
            kept,
            nothing,
            missed: 0.into(),
            panel_is_filled: false.into(),
        };
        if let Some(state) = self.images.locked().get_mut(&image) {
            state.target = Some(Arc::new(target));
        }
        device.scene_graph.note_scene(image);
        let mut scenes = self.scenes.locked();
        if !scenes.iter().any(|scene| scene.is_like(kind, size, window)) {
            scenes.push(KnownScene { kind, size, window });
        }
        Ok(())
    }

    /// Returns the view copies of the image of `view`, for draws to a window of `layout`; `None` if
    /// the image has none.
    ///
    /// # Errors
    /// The request that the driver refuses. Also fails if the image has the views of another window
    /// or of another state of the rig.
    pub fn view_copies(
        &self,
        device: &Device,
        view: vk::ImageView,
        layout: &AtlasLayout,
    ) -> Result<Option<ViewCopies>, Obstacle> {
        let (image, mut info, known, mut usage) = {
            let views = self.views.locked();
            let Some(state) = views.get(&view) else { return Ok(None) };
            let info = vk::ImageViewCreateInfo::default()
                .view_type(state.kind)
                .format(state.format)
                .components(state.components)
                .subresource_range(state.range);
            let usage = state.usage.map(|usage| vk::ImageViewUsageCreateInfo::default().usage(usage));
            (state.image, info, state.atlas_copies.clone(), usage)
        };
        let target = self.target_of_image(image);
        let target = match &target {
            Some(window) if window.window => self.window_copies(window),
            _ => target,
        };
        let Some(target) = target.filter(|target| !target.view_copies.is_empty()) else { return Ok(None) };
        if (target.layout.version, target.view_copies.len()) != (layout.version, layout.views.len()) {
            return Err("a picture of its scene has other views than the window".into());
        }
        if let Some(usage) = &mut usage {
            info = info.push_next(usage);
        }
        let mut all = Vec::with_capacity(target.view_copies.len());
        for view_copy in &target.view_copies {
            if let Some((_, known)) = known.iter().find(|(of, _)| *of == view_copy.image) {
                all.push(*known);
                continue;
            }
            // SAFETY: the view copy is live and has the format of the program's image.
            let made = unsafe { device.driver.functions.create_image_view(&info.image(view_copy.image), None) };
            let made = made.map_err(|error| format!("the driver refuses a view of an image: {error}"))?;
            all.push(made);
            if let Some(state) = self.views.locked().get_mut(&view) {
                state.atlas_copies.push((view_copy.image, made));
            }
        }
        Ok(Some(ViewCopies { of: Arc::downgrade(&target), views: all, layout: target.kept }))
    }

    /// Returns the layout of off-screen scenes of `size` that lead to a window of `layout`; `None` if
    /// they have another shape.
    fn layout_of(&self, layout: &Arc<AtlasLayout>, size: (u32, u32), most: u32) -> Option<Arc<AtlasLayout>> {
        let part = match viewport::has_shape(size, layout.window) {
            true => None,
            false => Some(AtlasRect::from(self.parts.locked().of_shape(size)?)),
        };
        Some(match self.even.load(Ordering::Relaxed) {
            true => layout.even(size, part, self.own_read.load(Ordering::Relaxed)),
            false => layout.of_image(size, part, most),
        })
    }
}
