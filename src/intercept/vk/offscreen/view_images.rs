//! Images for view copies, and per-view images of a window that compute shaders write.

use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::own_image::OwnImage;
use crate::intercept::vk::state::images::{Images, PendingLayout, aspects};
use crate::intercept::vk::state::views::atlas_layout::{AtlasLayout, AtlasRect};
use crate::intercept::vk::state::views::view_target::{ATLAS_COPY_USAGE, ViewTarget};
use crate::lock::Lock;
use ash::vk;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// View copies and their layout.
pub struct ViewImages {
    /// One for each view.
    pub view_copies: Vec<OwnImage>,
    /// Image of one clear texel, if compute shaders may write the view copies.
    pub nothing: Option<OwnImage>,
    /// The layout that they have between commands.
    pub kept: vk::ImageLayout,
}

/// Makes an image with one sample per texel.
///
/// # Errors
/// The request that the driver refuses.
fn image(
    device: &Device,
    ((width, height), levels): ((u32, u32), u32),
    flags: vk::ImageCreateFlags,
    (format, usage): (vk::Format, vk::ImageUsageFlags),
) -> Result<OwnImage, Obstacle> {
    // Compute shaders may run on other queues than draws do.
    let mut families: Vec<u32> = device.queues.locked().values().copied().collect();
    families.sort_unstable();
    families.dedup();
    let mut info = vk::ImageCreateInfo::default()
        .flags(flags)
        .image_type(vk::ImageType::TYPE_2D)
        .format(format)
        .extent(vk::Extent3D { width, height, depth: 1 })
        .mip_levels(levels)
        .array_layers(1)
        .samples(vk::SampleCountFlags::TYPE_1)
        .usage(usage | ATLAS_COPY_USAGE);
    if families.len() > 1 && usage.contains(vk::ImageUsageFlags::STORAGE) {
        info = info.sharing_mode(vk::SharingMode::CONCURRENT).queue_family_indices(&families);
    }
    // SAFETY: the device is live; the structure is complete.
    let made = unsafe { OwnImage::new(&device.driver, &info) };
    made.map_err(|error| format!("the driver refuses an image of {width} × {height}: {error}").into())
}

impl Images {
    /// Makes images as large as these tiles, with the properties of an image of this kind and this
    /// number of levels.
    ///
    /// # Errors
    /// The request that the driver refuses.
    pub(super) fn view_images(
        &self,
        device: &Device,
        (tiles, levels): (&[AtlasRect], u32),
        flags: vk::ImageCreateFlags,
        (format, usage): (vk::Format, vk::ImageUsageFlags),
    ) -> Result<ViewImages, Obstacle> {
        let stored = usage.contains(vk::ImageUsageFlags::STORAGE);
        let kept = match stored {
            true => vk::ImageLayout::GENERAL,
            false => vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        };
        let usage = usage & (vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::STORAGE);
        let mut made: Vec<OwnImage> = Vec::with_capacity(tiles.len() + 1);
        let of_tiles = tiles.iter().map(|tile| (tile.width.max(1) as u32, tile.height.max(1) as u32));
        let of_tiles = of_tiles.map(|size| (size, levels));
        for size in of_tiles.chain(stored.then_some(((1, 1), 1))) {
            let new = image(device, size, flags, (format, usage)).inspect_err(|_| {
                // SAFETY: images of Cupola that nothing uses yet.
                made.iter().for_each(|image| unsafe { image.destroy(&device.driver) });
            })?;
            made.push(new);
        }
        let nothing = if stored { made.pop() } else { None };
        let brought = |cleared: bool| {
            move |own: &OwnImage| PendingLayout {
                image: own.image,
                layout: kept,
                aspects: aspects(format),
                cleared,
                filled: None,
            }
        };
        let mut pending = self.pending.locked();
        pending.extend(made.iter().map(brought(false)));
        pending.extend(nothing.iter().map(brought(true)));
        Ok(ViewImages { view_copies: made, nothing, kept })
    }

    /// Returns the images that compute shaders write instead of a window's, if they were made.
    pub fn window_copies(&self, window: &ViewTarget) -> Option<Arc<ViewTarget>> {
        let known = self.of_window.locked();
        known.as_ref().filter(|known| known.layout.has_views_of(&window.layout)).map(Arc::clone)
    }

    /// Returns the images that compute shaders write instead of a window's, which are made if
    /// necessary: one for each view, as large as the window. All images of a swapchain share them.
    ///
    /// # Errors
    /// The request that the driver refuses.
    pub fn make_window_copies(&self, device: &Device, window: &ViewTarget) -> Result<Arc<ViewTarget>, Obstacle> {
        let layout = window.layout.even(window.layout.window, None, self.own_read.load(Ordering::Relaxed));
        if let Some(known) = self.window_copies(window).filter(|known| Arc::ptr_eq(&known.layout, &layout)) {
            return Ok(known);
        }
        let format = self.format(window.given).ok_or("a window that is not known")?;
        let flags = vk::ImageCreateFlags::MUTABLE_FORMAT | vk::ImageCreateFlags::EXTENDED_USAGE;
        let tiles: Vec<AtlasRect> = layout.views.iter().map(|view| view.rect).collect();
        let ViewImages { view_copies, nothing, kept } =
            self.view_images(device, (&tiles, 1), flags, (format, vk::ImageUsageFlags::STORAGE))?;
        let of_window = ViewTarget::of_window(layout, vk::Image::null(), vk::Image::null());
        let made = Arc::new(ViewTarget { window: false, view_copies, nothing, kept, ..of_window });
        let old = self.of_window.locked().replace(Arc::clone(&made));
        self.retired.locked().extend(old);
        Ok(made)
    }

    /// Returns an image with the format of an image that holds a scene, as large as the atlas of
    /// another layout. Texels can be scaled in it before they are copied bit by bit. It follows the
    /// layout of the scene's image.
    ///
    /// # Errors
    /// The request that the driver refuses.
    pub fn scaled_atlas(&self, device: &Device, of: vk::Image, layout: &AtlasLayout) -> Result<vk::Image, Obstacle> {
        if let Some(known) = self.atlas_copy_of_size(of, layout.atlas) {
            return Ok(known);
        }
        let mut images = self.images.locked();
        let state = images.get_mut(&of).ok_or("it copies an image that is not known")?;
        let made = image(device, (layout.atlas, 1), state.flags, (state.format, state.usage))?;
        let (image, aspects) = (made.image, aspects(state.format));
        state.atlas_copies.push((layout.atlas, made));
        self.pending.locked().push(PendingLayout {
            image,
            layout: state.layout,
            aspects,
            cleared: false,
            filled: None,
        });
        Ok(image)
    }
}
