//! Copies of all views of a scene, tile by tile, to a target with tiles of other sizes or to a part of
//! the window.

use crate::backend::vk::Use;
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::commands::copies::regions::Region;
use crate::intercept::vk::offscreen::view_copies;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::own_image::{COLOR_LAYER, COPIED_TO, barrier_of, left_in, ready_in};
use crate::intercept::vk::state::views::atlas_layout::AtlasRect;
use crate::intercept::vk::state::views::view_target::ViewTarget;
use ash::vk;
use std::sync::Arc;

/// A copy of all views of a scene.
pub struct ScaledCopy<'a> {
    pub(super) device: &'a Device,
    pub(super) buffer: vk::CommandBuffer,
    /// The program's image that is read.
    pub(super) given: vk::Image,
    /// Its views.
    pub(super) read: Arc<ViewTarget>,
    /// The views that are written.
    pub(super) target: Arc<ViewTarget>,
    /// The part of the window that is written; `None`: all of the picture.
    pub(super) part: Option<AtlasRect>,
    /// Layouts of both images.
    pub(super) layouts: [vk::ImageLayout; 2],
}

impl ScaledCopy<'_> {
    /// Records the copies. `next` (from, to, regions) records the program's command, which has these
    /// `regions`.
    ///
    /// # Errors
    /// The reason why it cannot. Nothing is recorded then.
    ///
    /// # Safety
    /// The command buffer is being recorded, outside of a pass.
    pub(super) unsafe fn record<R: Region>(
        &self,
        regions: &[R],
        next: &dyn Fn(vk::Image, vk::Image, &[R]),
    ) -> Result<(), Obstacle> {
        let Self { device, buffer, read, target, layouts: [from_layout, layout], .. } = self;
        let scaled = self.image_between::<R>()?;
        device.recordings.with(*buffer, |recording| recording.samples(Arc::clone(read)));
        let changed = |change: &dyn Fn(&mut R)| {
            let mut changed = regions.to_vec();
            changed.iter_mut().for_each(change);
            changed
        };
        // SAFETY: as promised.
        let bring = |from: Use, to: Use| {
            scaled.iter().for_each(|image| unsafe {
                barrier_of(&device.driver, *buffer, (*image, read.aspects), from, to);
            })
        };
        let of_view = |image: vk::Image, from: AtlasRect, to: AtlasRect| {
            let (end, end_layout) = scaled.map_or((target.atlas, *layout), |scaled| (scaled, COPIED_TO.layout));
            let is_same = scaled.is_none() && (from.width, from.height) == (to.width, to.height);
            match R::SCALES || is_same {
                true => next(image, target.atlas, &changed(&|region| region.take(from, to))),
                // SAFETY: as promised.
                false => unsafe { scale(device, *buffer, (image, from, *from_layout), (end, to, end_layout)) },
            }
        };
        bring(left_in(*from_layout), COPIED_TO);
        // SAFETY: as promised; the atlas has just been written in this layout.
        unsafe {
            view_copies::read(device, *buffer, read, *from_layout, || self.copy_views(&of_view));
            self.copy_other_tiles(&of_view);
            bring(COPIED_TO, ready_in(*from_layout));
            if let Some(scaled) = scaled {
                let (width, height) = target.layout.atlas;
                let size = vk::Extent3D { width, height, depth: 1 };
                next(scaled, target.atlas, &changed(&|region| region.take_all(size)));
            }
            view_copies::make(device, *buffer, target, *layout);
        }
        Ok(())
    }

    /// Returns an image in which the views are scaled in the format of the first image, if that is
    /// needed: a copy keeps bits, and a blit keeps values.
    ///
    /// # Errors
    /// The reason why the copy cannot be recorded.
    fn image_between<R: Region>(&self) -> Result<Option<vk::Image>, Obstacle> {
        let Self { device, given, read, target, part, .. } = self;
        let same_size = read.layout.atlas == target.layout.atlas;
        if R::RESOLVES && (!same_size || part.is_some()) {
            return Err("it resolves its picture into an image with other views".into());
        }
        let keeps_bits = !R::SCALES && device.images.format(*given) != device.images.format(target.given);
        let size = |rect: AtlasRect| (rect.width, rect.height);
        let mut tiles = read.layout.views.iter().zip(&target.layout.views);
        let same_tiles = tiles.all(|(from, to)| size(from.rect) == size(to.rect));
        match part {
            None if keeps_bits && !same_size => device.images.scaled_atlas(device, *given, &target.layout).map(Some),
            // Such an image would be copied over the widgets.
            Some(_) if keeps_bits && !same_tiles => {
                Err("it copies its picture to an image with another format and other views".into())
            }
            _ => Ok(None),
        }
    }

    /// Copies the views, and empties the panel where the picture is, with `of_view` (image, from, to).
    fn copy_views(&self, of_view: &dyn Fn(vk::Image, AtlasRect, AtlasRect)) {
        let Self { read, target, part, .. } = self;
        // A filter would read texels beside a tile, but reads none beside an image.
        let mut view_copies = read.view_copies.iter();
        for (from, to) in read.layout.views.iter().zip(&target.layout.views) {
            match view_copies.next() {
                Some(view_copy) => of_view(view_copy.image, whole(from.rect), to.rect),
                None => of_view(read.atlas, from.rect, to.rect),
            }
        }
        if let Some(nothing) = &read.nothing {
            // In the window's atlas tiles have gaps between them, and a filter reads texels beside
            // the panel.
            let border = target.window && part.is_none();
            let layout = &target.layout;
            let panel = if border { layout.panel_with_border() } else { self.shown_in(layout.panel) };
            of_view(nothing.image, AtlasRect { x: 0, y: 0, width: 1, height: 1 }, panel);
        }
    }

    /// Copies the program's own picture and, if nothing else does so, empties the panel.
    fn copy_other_tiles(&self, of_view: &dyn Fn(vk::Image, AtlasRect, AtlasRect)) {
        let Self { device, read, target, .. } = self;
        // The program's image holds what compute shaders wrote, and also what was drawn, if that can
        // be copied there.
        let in_image = read.is_stored() && !device.images.lacks_own_picture(read.given);
        match (in_image, target.layout.primary, read.layout.primary) {
            (true, Some(to), _) => of_view(read.given, whole(read.layout.panel), self.shown_in(to)),
            (false, Some(to), Some(from)) => of_view(read.atlas, from, self.shown_in(to)),
            _ => {}
        }
        if !read.is_stored() {
            // The panel of an off-screen scene is empty. Only its middle is read, so that a filter
            // reads no texels beside the panel.
            of_view(read.atlas, read.layout.panel.middle(), self.shown_in(target.layout.panel));
        }
    }

    /// Returns the rectangle of a tile of the window that the picture fills.
    fn shown_in(&self, tile: AtlasRect) -> AtlasRect {
        self.part.map_or(tile, |part| part.moved_into(tile))
    }
}

/// Returns the rectangle of an image that is as large as a tile.
fn whole(AtlasRect { width, height, .. }: AtlasRect) -> AtlasRect {
    AtlasRect { x: 0, y: 0, width, height }
}

/// Blits a rectangle of an image in a layout to a rectangle of another image.
///
/// # Safety
/// The command buffer is being recorded, outside of a pass.
unsafe fn scale(
    device: &Device,
    buffer: vk::CommandBuffer,
    (from, read, read_layout): (vk::Image, AtlasRect, vk::ImageLayout),
    (to, written, layout): (vk::Image, AtlasRect, vk::ImageLayout),
) {
    let mut region = vk::ImageBlit::default().src_subresource(COLOR_LAYER).dst_subresource(COLOR_LAYER);
    region.take(read, written);
    // SAFETY: as promised; the rectangles lie in the images.
    unsafe {
        let filter = vk::Filter::LINEAR;
        device.driver.functions.cmd_blit_image(buffer, from, read_layout, to, layout, &[region], filter);
    }
}
